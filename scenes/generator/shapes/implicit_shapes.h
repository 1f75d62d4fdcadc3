#pragma once

#include <memory>
#include <vector>

#include "engine/base/types.h"

/// Organs as implicit shapes: a field that is negative in the shape, zero on its surface and about
/// the distance to it nearby, in metres. Only + - * / and sqrt appear, so that every x86-64 machine
/// computes the same bits whatever its mathematics library.
///
/// Frame of the organs: origin at the centre of volume, x to the patient's left, y towards the
/// head, z to the front (up, towards a laparoscope's abdominal wall, in a patient on the back).
namespace hpdm {

/// The field and its gradient at one point.
struct FieldSample {
  double value = 0;                      ///< m, negative inside.
  Vector3d gradient = Vector3d::Zero();  ///< Dimensionless; of length one for a true distance.
};

/// Axis-aligned box, m.
struct Bounds {
  Vector3d min = Vector3d::Zero();
  Vector3d max = Vector3d::Zero();
};

/// A closed shape. Immutable: any thread may sample it.
class ImplicitShape {
 public:
  virtual ~ImplicitShape() = default;
  virtual FieldSample Sample(const Vector3d& p) const = 0;
  /// A box that holds the surface with room to spare.
  virtual Bounds bounds() const = 0;
};

/// Nearest point of the field's level set (field = `level`, m) along the gradient, by Newton steps
/// of at most 5 mm; where the gradient vanishes the point stays as it is.
Vector3d ProjectToLevel(const ImplicitShape& shape, const Vector3d& p, double level);

/// The surface's point nearest to p, for p no deeper than the surface's radius of curvature: steps
/// along the surface, halved for convergence near sharp rounds, until p lies on the normal. Where
/// shapes are joined the field is less than the distance, and this finds the distance.
Vector3d NearestSurfacePoint(const ImplicitShape& shape, const Vector3d& p);

/// Union (smallest value) of two fields, rounded where they differ by less than `rounding` (m) so
/// that the gradient is continuous: min(a, b) - h^2 rounding / 4, h = 1 - |a - b| / rounding.
FieldSample SmoothUnion(const FieldSample& a, const FieldSample& b, double rounding);

/// `a` without `b`, rounded in the same way.
FieldSample SmoothDifference(const FieldSample& a, const FieldSample& b, double rounding);

/// An ellipsoid; the field is the distance to first order in the distance.
class Ellipsoid : public ImplicitShape {
 public:
  /// `semi_axes` (m) along `axis`, along `up` made square to it, and along their cross product.
  Ellipsoid(const Vector3d& centre, const Vector3d& semi_axes,
            const Vector3d& axis = Vector3d::UnitX(), const Vector3d& up = Vector3d::UnitY());
  FieldSample Sample(const Vector3d& p) const override;
  Bounds bounds() const override;

 private:
  Vector3d centre_;
  Vector3d semi_axes_;
  Matrix3d axes_;  ///< Columns: unit axes.
};

/// The union of the balls whose centre and radius run along a cubic B-spline that starts at the
/// first node and ends at the last: a tube with round ends. The field is the exact distance as
/// far as the nearest ball is unique, so that the surface at -w is a wall's inner side w deep.
class SweptBall : public ImplicitShape {
 public:
  struct Node {
    Vector3d centre;
    double radius;
  };
  /// At least two nodes, and a radius that changes more slowly than the centre moves.
  explicit SweptBall(std::vector<Node> nodes);
  FieldSample Sample(const Vector3d& p) const override;
  Bounds bounds() const override;

 private:
  /// The ball at parameter t in [0, span_count()] and its derivative.
  struct Ball {
    Vector3d centre, centre_rate;
    double radius, radius_rate;
  };
  int span_count() const { return static_cast<int>(nodes_.size()) - 3; }
  Ball At(double t) const;
  /// Where in [low, high] the ball is nearest to p, when that holds one minimum.
  double NearestParameter(const Vector3d& p, double low, double high) const;

  std::vector<Node> nodes_;  ///< With one more beyond each end.
  std::vector<Ball> balls_;  ///< At equal steps of t, to find the nearest one.
};

/// A liver of 1.5 l and about 0.21 m: a large right and a tapering left lobe, a domed
/// diaphragmatic surface (up and to the front), a concave visceral side (down and to the back), a
/// sharp inferior border with the notch of the falciform ligament, and the gallbladder's fossa.
std::unique_ptr<ImplicitShape> LiverShape();

/// A J-shaped stomach with fundus, body, antrum, pylorus and the end of the oesophagus.
std::unique_ptr<ImplicitShape> StomachShape();

/// The lines along the stomach's long (left, lower) and short (right, upper) border, from the
/// fundus to the pylorus, where its vessels and the omenta come to it: m, in its frame, near the
/// surface.
std::vector<Vector3d> StomachGreaterCurvature();
std::vector<Vector3d> StomachLesserCurvature();

/// A pear-shaped gallbladder, 80 mm long and 30 mm wide, that ends in a bent neck.
std::unique_ptr<ImplicitShape> GallbladderShape();

/// Middle of the gallbladder's neck, m, in its frame.
Vector3d GallbladderNeck();

}  // namespace hpdm
