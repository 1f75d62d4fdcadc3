#include <algorithm>

#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {
namespace {

/// Lengths below are in millimetres, in a frame with the header's axes; the classes move the centre
/// of volume to the origin.
constexpr double kMillimetre = 1e-3;

Ellipsoid MillimetreEllipsoid(double x, double y, double z, double a, double b, double c,
                              const Vector3d& axis = Vector3d::UnitX(),
                              const Vector3d& up = Vector3d::UnitY()) {
  return Ellipsoid(kMillimetre * Vector3d(x, y, z), kMillimetre * Vector3d(a, b, c), axis, up);
}

SweptBall::Node MillimetreNode(double x, double y, double z, double radius) {
  return {kMillimetre * Vector3d(x, y, z), kMillimetre * radius};
}

/// Two joined lobes minus the impressions of the neighbours. The border between the convex
/// diaphragmatic surface and the large concave impression of the viscera is the inferior border.
class Liver : public ImplicitShape {
 public:
  FieldSample Sample(const Vector3d& p_O) const override {
    const Vector3d p = (p_O / kScale) + centre_;
    FieldSample liver = SmoothUnion(right_lobe_.Sample(p), left_lobe_.Sample(p), 40 * kMillimetre);
    liver = SmoothDifference(liver, heart_.Sample(p), 30 * kMillimetre);
    liver = SmoothDifference(liver, spine_.Sample(p), 25 * kMillimetre);
    liver = SmoothDifference(liver, kidney_.Sample(p), 14 * kMillimetre);
    liver = SmoothDifference(liver, viscera_.Sample(p), 7 * kMillimetre);
    liver = SmoothDifference(liver, gallbladder_.Sample(p), 7 * kMillimetre);
    liver = SmoothDifference(liver, notch_.Sample(p), 8 * kMillimetre);
    liver = SmoothDifference(liver, falciform_.Sample(p), 10 * kMillimetre);
    liver.value *= kScale;
    return liver;
  }

  Bounds bounds() const override {
    return {Vector3d(-0.095, -0.115, -0.09), Vector3d(0.145, 0.08, 0.07)};
  }

 private:
  // Found by meshing: these give a volume of 1.5 l centred at the origin.
  static constexpr double kScale = 0.96674;
  const Vector3d centre_ = kMillimetre * Vector3d(-25.62, 16.64, 9.44);

  const Ellipsoid right_lobe_ = MillimetreEllipsoid(-22, -6, -2, 86, 94, 70);
  const Ellipsoid left_lobe_ = MillimetreEllipsoid(40, 38, 13, 74, 41, 41, {1, 0.16, -0.14});
  const Ellipsoid viscera_ =
      MillimetreEllipsoid(101, -119, -89, 210, 180, 180, {0.82, 0.54, 0.1}, {-0.55, 0.67, 0.5});
  // The hollow of the back, around the spine and the inferior vena cava.
  const Ellipsoid spine_ = MillimetreEllipsoid(24, 10, -84, 44, 140, 50);
  // The cardiac impression in the dome between the lobes.
  const Ellipsoid heart_ = MillimetreEllipsoid(55, 124, 10, 80, 44, 60);
  const Ellipsoid kidney_ = MillimetreEllipsoid(-58, -66, -64, 34, 50, 34);
  const Ellipsoid gallbladder_ =
      MillimetreEllipsoid(-22, -46, 13, 14, 46, 15, {1, 0, 0}, {0, 1, -0.6});
  // The fissure that the round ligament cuts into the inferior border.
  const Ellipsoid notch_ = MillimetreEllipsoid(28, -24, 40, 5, 20, 24, {1, 0.25, 0});
  // The shallow groove of the falciform ligament over the dome.
  const Ellipsoid falciform_ = MillimetreEllipsoid(20, 25, 105, 7, 75, 40);
};

// Found by meshing: the centre of the volume within the outer surface.
const Vector3d kStomachCentre = kMillimetre * Vector3d(31.68, 9.76, -2.21);
const Vector3d kGallbladderCentre = kMillimetre * Vector3d(0.12, -8.30, 0.93);

std::vector<SweptBall::Node> StomachNodes() {
  return {MillimetreNode(58, 92, -16, 38), MillimetreNode(58, 66, -12, 47),
          MillimetreNode(52, 24, -4, 43),  MillimetreNode(35, -32, 6, 36),
          MillimetreNode(-2, -80, 12, 32), MillimetreNode(-48, -86, 12, 25),
          MillimetreNode(-80, -62, 8, 16), MillimetreNode(-94, -42, 2, 12)};
}

/// A tube from the fundus over the body and the antrum to the pylorus, and the oesophagus' end.
class Stomach : public ImplicitShape {
 public:
  FieldSample Sample(const Vector3d& p_O) const override {
    const Vector3d p = p_O + kStomachCentre;
    return SmoothUnion(body_.Sample(p), oesophagus_.Sample(p), 22 * kMillimetre);
  }

  Bounds bounds() const override {
    return {Vector3d(-0.15, -0.13, -0.065), Vector3d(0.085, 0.135, 0.057)};
  }

 private:
  const SweptBall body_{StomachNodes()};
  const SweptBall oesophagus_{{MillimetreNode(32, 42, -8, 16), MillimetreNode(6, 62, -10, 12.5),
                               MillimetreNode(-18, 88, -14, 12)}};
};

/// Returns the stomach's border to the left (`side` = 1) or right (-1) of its course from fundus to
/// pylorus, in the frontal plane.
std::vector<Vector3d> StomachCurvature(double side) {
  const std::vector<SweptBall::Node> nodes = StomachNodes();
  std::vector<Vector3d> border;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const Vector3d along =
        nodes[std::min(i + 1, nodes.size() - 1)].centre - nodes[i == 0 ? 0 : i - 1].centre;
    const Vector3d left(-along.y(), along.x(), 0);
    border.push_back(nodes[i].centre + left * (side * nodes[i].radius / left.norm()) -
                     kStomachCentre);
  }
  return border;
}

/// A tube from the fundus (below, in front) to the neck, whose bend leads to the cystic duct.
class Gallbladder : public ImplicitShape {
 public:
  FieldSample Sample(const Vector3d& p_O) const override {
    return body_.Sample(p_O + kGallbladderCentre);
  }
  Bounds bounds() const override {
    return {Vector3d(-0.022, -0.04, -0.022), Vector3d(0.022, 0.058, 0.024)};
  }

 private:
  const SweptBall body_{{MillimetreNode(0, -25, 2, 15), MillimetreNode(0, -14, 1, 15.2),
                         MillimetreNode(0, 2, 0, 13), MillimetreNode(1, 16, -1, 9),
                         MillimetreNode(3, 26, -1, 6.5), MillimetreNode(0, 34, 2, 5.5),
                         MillimetreNode(-6, 35, 4, 5)}};
};

/// A solid bent like a J. Its two limbs are 10 mm apart over half of the shorter one's length.
class BentOrgan : public ImplicitShape {
 public:
  FieldSample Sample(const Vector3d& p_O) const override { return body_.Sample(p_O); }
  Bounds bounds() const override {
    return {Vector3d(-0.055, -0.11, -0.03), Vector3d(0.055, 0.12, 0.03)};
  }

 private:
  const SweptBall body_{{MillimetreNode(22, 90, 0, 22), MillimetreNode(22, 30, 0, 22),
                         MillimetreNode(22, -20, 0, 22), MillimetreNode(18, -58, 0, 21),
                         MillimetreNode(-4, -78, 0, 20), MillimetreNode(-26, -58, 0, 18),
                         MillimetreNode(-28, -24, 0, 17), MillimetreNode(-27, 10, 0, 16)}};
};

}  // namespace

std::unique_ptr<ImplicitShape> LiverShape() { return std::make_unique<Liver>(); }
std::unique_ptr<ImplicitShape> StomachShape() { return std::make_unique<Stomach>(); }
std::unique_ptr<ImplicitShape> GallbladderShape() { return std::make_unique<Gallbladder>(); }
std::unique_ptr<ImplicitShape> BentOrganShape() { return std::make_unique<BentOrgan>(); }

std::vector<Vector3d> StomachGreaterCurvature() { return StomachCurvature(1); }
std::vector<Vector3d> StomachLesserCurvature() { return StomachCurvature(-1); }

Vector3d GallbladderNeck() { return kMillimetre * Vector3d(0, 34, 2) - kGallbladderCentre; }

}  // namespace hpdm
