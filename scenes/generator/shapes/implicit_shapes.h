#pragma once

#include <memory>
#include <vector>

#include "engine/base/types.h"

/// Organs as implicit shapes: a field in metres that is negative inside, zero on the surface and
/// about the distance to it nearby. Only + - * / and sqrt are used, so that every x86-64 machine
/// computes the same bits with any mathematics library.
///
/// Frame of the organs: origin at the centre of volume, x to the patient's left, y towards the
/// head, z to the front (up, towards a laparoscope's abdominal wall, in a patient on the back).
namespace hpdm {

/// The field and its gradient at one point.
struct FieldSample {
  double value = 0;                      ///< m, negative inside.
  Vector3d gradient = Vector3d::Zero();  ///< Dimensionless; length one for an exact distance.
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
  /// Returns a box that contains the surface with a margin.
  virtual Bounds bounds() const = 0;
};

/// Projects p along the gradient to the level set field = `level` (m), by Newton steps of at most 5
/// mm. A point without a gradient stays.
Vector3d ProjectToLevel(const ImplicitShape& shape, const Vector3d& p, double level);

/// Returns the surface's point nearest to p, for p no deeper than the surface's radius of
/// curvature. Steps along the surface until p lies on the normal; halves steps near sharp rounds to
/// converge. Unlike the field, it gives the distance of joined shapes exactly.
Vector3d NearestSurfacePoint(const ImplicitShape& shape, const Vector3d& p);

/// Returns the union (smallest value) of two fields, rounded where they differ by less than
/// `rounding` (m), with a continuous gradient:
///   min(a, b) - h^2 rounding / 4, h = 1 - |a - b| / rounding.
FieldSample SmoothUnion(const FieldSample& a, const FieldSample& b, double rounding);

/// Returns `a` without `b`, rounded like SmoothUnion.
FieldSample SmoothDifference(const FieldSample& a, const FieldSample& b, double rounding);

/// An ellipsoid. The field is the distance to first order.
class Ellipsoid : public ImplicitShape {
 public:
  /// `semi_axes` (m) lie along `axis`, `up` made orthogonal to it, and their cross product.
  Ellipsoid(const Vector3d& centre, const Vector3d& semi_axes,
            const Vector3d& axis = Vector3d::UnitX(), const Vector3d& up = Vector3d::UnitY());
  FieldSample Sample(const Vector3d& p) const override;
  Bounds bounds() const override;

 private:
  Vector3d centre_;
  Vector3d semi_axes_;
  Matrix3d axes_;  ///< Columns: unit axes.
};

/// A tube with round ends: the union of balls whose centre and radius follow a cubic B-spline from
/// the first node to the last. The field is the exact distance while the nearest ball is unique, so
/// the surface at -w is the inner side of a wall of thickness w.
class SweptBall : public ImplicitShape {
 public:
  struct Node {
    Vector3d centre;
    double radius;
  };
  /// Needs at least two nodes, and a radius that changes more slowly than the centre moves.
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
  /// Returns the t in [low, high] of the ball nearest to p, for an interval with one minimum.
  double NearestParameter(const Vector3d& p, double low, double high) const;

  std::vector<Node> nodes_;  ///< With one extra node beyond each end.
  std::vector<Ball> balls_;  ///< At equal steps of t, to find the nearest one.
};

/// A liver of 1.5 l and about 0.21 m: a large right and a tapering left lobe, a domed
/// diaphragmatic surface (up and to the front), a concave visceral side (down and to the back), a
/// sharp inferior border with the notch of the falciform ligament, and the gallbladder's fossa.
std::unique_ptr<ImplicitShape> LiverShape();

/// A J-shaped stomach with fundus, body, antrum, pylorus and the end of the oesophagus.
std::unique_ptr<ImplicitShape> StomachShape();

/// Lines near the surface along the stomach's long (left, lower) and short (right, upper) border,
/// from the fundus to the pylorus, m, in its frame. Vessels and omenta reach the stomach there.
std::vector<Vector3d> StomachGreaterCurvature();
std::vector<Vector3d> StomachLesserCurvature();

/// A pear-shaped gallbladder, 80 mm long and 30 mm wide, that ends in a bent neck.
std::unique_ptr<ImplicitShape> GallbladderShape();

/// A solid bent like a J, 44 to 32 mm thick, whose limbs are 10 mm apart. In the organs' frame but
/// for its origin.
std::unique_ptr<ImplicitShape> BentOrganShape();

/// Middle of the gallbladder's neck, m, in its frame.
Vector3d GallbladderNeck();

}  // namespace hpdm
