#include "scenes/generator/anatomy/anatomy.h"

#include <array>
#include <optional>

#include "scenes/generator/shapes/solid_builder.h"
#include "scenes/generator/shapes/solid_noise.h"

namespace hpdm {
namespace {

constexpr double kMillimetre = 1e-3;

/// A node of a tube, in millimetres.
SweptBall::Node Node(double x, double y, double z, double radius) {
  return {kMillimetre * Vector3d(x, y, z), kMillimetre * radius};
}

Vector3d Point(double x, double y, double z) { return kMillimetre * Vector3d(x, y, z); }

/// A tube with a rounded bulge.
class TubeWithPouch : public ImplicitShape {
 public:
  TubeWithPouch(SweptBall tube, const Ellipsoid& pouch, double rounding)
      : tube_(std::move(tube)), pouch_(pouch), rounding_(rounding) {}
  FieldSample Sample(const Vector3d& p) const override {
    return SmoothUnion(tube_.Sample(p), pouch_.Sample(p), rounding_);
  }
  Bounds bounds() const override {
    const Bounds a = tube_.bounds(), b = pouch_.bounds();
    const Vector3d bulge = Vector3d::Constant(rounding_);
    return {a.min.cwiseMin(b.min) - bulge, a.max.cwiseMax(b.max) + bulge};
  }

 private:
  SweptBall tube_;
  Ellipsoid pouch_;
  double rounding_;
};

/// Differences between two patients of one variant.
class Variation {
 public:
  explicit Variation(std::uint64_t seed) : random_(seed), varies_(seed != 0) {}
  /// Returns a number between `low` and `high`; the mean for seed 0.
  double Between(double low, double high) {
    const double t = random_.Fraction();
    return low + (high - low) * (varies_ ? t : 0.5);
  }

 private:
  RandomNumbers random_;
  bool varies_;
};

/// Turns a point of the gallbladder's frame into the world.
Vector3d InWorld(const Vector3d& p, const Vector3d& position) {
  const auto [c, s] = CosineSine(-Anatomy::kTiltTurns);
  return position + Vector3d(p.x(), c * p.y() + s * p.z(), -s * p.y() + c * p.z());
}

/// Turns a point of the world into the gallbladder's frame.
Vector3d InGallbladder(const Vector3d& p, const Vector3d& position) {
  const auto [c, s] = CosineSine(-Anatomy::kTiltTurns);
  const Vector3d q = p - position;
  return {q.x(), c * q.y() - s * q.z(), s * q.y() + c * q.z()};
}

/// Middle line of the gallbladder from its fundus to its neck, its own frame. The body lies in the
/// liver's fossa, so it is never thicker there than the mean.
std::vector<SweptBall::Node> GallbladderNodes(Variation* variation) {
  const double fundus = variation->Between(-3, 3);  // mm longer
  const double girth = variation->Between(0.94, 1.0);
  const double reach = variation->Between(-1, 1);
  return {Node(0, -16.7 - fundus, 1.1, 15 * girth),
          Node(0, -5.7, 0.1, 15.2 * girth),
          Node(0, 10.3, -0.9, 13 * girth),
          Node(1, 24.3, -2.2, 9.2),
          Node(3, 33.3, -2.8, 7),
          Node(7, 41 + reach, -3.5, 5.2),
          Node(12 + reach, 45 + reach, -6, 3.8)};
}

struct Trunks {
  std::vector<SweptBall::Node> duct, artery;
};

/// The hepatic and common bile duct from the porta of the liver downwards, and the right hepatic
/// artery from the ligament into the liver, m, world.
Trunks MakeTrunks(AnatomyVariant variant, Variation* variation) {
  const double x = variation->Between(-1.5, 1.5), z = variation->Between(-1.5, 1.5);
  Trunks trunks;
  trunks.duct = {Node(22, 2, -24, 3.4),           Node(25, -12, -27, 3.4),
                 Node(27 + x, -28, -30 + z, 3.4), Node(29 + x, -45, -34 + z, 3.4),
                 Node(30 + x, -62, -41 + z, 3.5), Node(31 + x, -80, -51 + z, 3.6),
                 Node(29, -98, -63, 3.6)};
  if (variant == AnatomyVariant::kShortDuct) {
    trunks.duct[2].centre += Point(-1, 0, 2);
    trunks.duct[3].centre += Point(-4, 0, 9);
    trunks.duct[4].centre += Point(-2, 0, 6);
  }
  if (variant == AnatomyVariant::kArteryInFront) {
    trunks.artery = {Node(37, -82, -58, 2.5), Node(44, -64, -45, 2.5),
                     Node(43, -50, -29, 2.4), Node(32 + x, -40, -21 + z, 2.2),
                     Node(23, -30, -20, 2.1), Node(17, -18, -24, 2.0),
                     Node(13, -2, -33, 2.0)};
  } else {
    trunks.artery = {Node(37, -82, -60, 2.5), Node(43, -64, -53, 2.5),
                     Node(42, -48, -46, 2.4), Node(31 + x, -37, -41 + z, 2.2),
                     Node(22, -28, -36, 2.1), Node(16, -18, -33, 2.0),
                     Node(12, -2, -36, 2.0)};
  }
  return trunks;
}

/// Way of the cystic duct between its ends, m, world.
std::vector<Vector3d> CysticDuctWay(AnatomyVariant variant, Variation* variation) {
  const double bow = variation->Between(-1.5, 1.5);
  switch (variant) {
    case AnatomyVariant::kShortDuct:
      return {Point(25, -42 + bow, -17)};
    case AnatomyVariant::kLowUnion:
      return {Point(24, -42, -17), Point(23.5 + bow, -50, -27), Point(23.5 + bow, -60, -35),
              Point(23.5 + bow, -70, -42), Point(24, -79, -47.5)};
    case AnatomyVariant::kUsual:
    case AnatomyVariant::kArteryInFront:
      break;
  }
  return {Point(24.5, -42, -16.5), Point(25 + bow, -48, -23), Point(25.5 + bow, -54, -30)};
}

/// Returns a point near the common duct's middle line at which the cystic duct joins it, m, world.
Vector3d Union(AnatomyVariant variant) {
  switch (variant) {
    case AnatomyVariant::kShortDuct:
      return Point(26, -46, -25);
    case AnatomyVariant::kLowUnion:
      return Point(30, -86, -53);
    case AnatomyVariant::kUsual:
    case AnatomyVariant::kArteryInFront:
      break;
  }
  return Point(29.5, -60, -38);
}

/// Points of the cystic artery, m, world: the first near the right hepatic artery's middle line, the
/// last on the gallbladder's neck.
std::vector<Vector3d> CysticArteryWay(AnatomyVariant variant, Variation* variation) {
  const double bow = variation->Between(-1, 1);
  if (variant == AnatomyVariant::kArteryInFront) {
    return {Point(33, -41, -21), Point(29, -45, -14 + bow), Point(24, -46.5, -8 + bow),
            Point(18, -45, -5)};
  }
  return {Point(21, -26.5, -35), Point(19, -28, -28), Point(17.5, -31 + bow, -20),
          Point(16, -36, -11)};
}

/// Moves a tube's end onto an organ's surface, `depth` inside.
Vector3d IntoTissue(const ImplicitShape& shape, const Vector3d& p, double depth) {
  return ProjectToLevel(shape, p, -depth);
}

/// The leaf from the left side of the gallbladder's neck to the liver's inferior face in front of it.
Anatomy::Leaf FrontLeaf(const ImplicitShape& gallbladder, const Vector3d& position) {
  Anatomy::Leaf leaf;
  for (const Vector3d& p :
       {Point(10.6, 18, 4), Point(10, 29, 0), Point(10.5, 35, 0.5), Point(13, 41.5, -2)}) {
    leaf.on_gallbladder.push_back(InWorld(ProjectToLevel(gallbladder, p, 0), position));
  }
  const auto liver = LiverShape();
  for (const Vector3d& p :
       {Point(16, -62, 26), Point(20, -55, 24), Point(24, -49, 24), Point(28, -44, 23)}) {
    leaf.on_liver.push_back(ProjectToLevel(*liver, p, 0));
  }
  return leaf;
}

}  // namespace

Anatomy::Anatomy(AnatomyVariant variant, std::uint64_t seed)
    : gallbladder_position(Point(8, -82.4, 11.5)) {
  Variation variation(seed);
  const std::vector<SweptBall::Node> nodes = GallbladderNodes(&variation);
  const double pouch = variation.Between(0.85, 1.15);
  const auto body = std::make_shared<TubeWithPouch>(
      SweptBall(nodes),
      Ellipsoid(Point(2, 30, -9.5), pouch * Point(7.5, 9.5, 7.5), {0, 1, 0}, {1, 0, 0}),
      5 * kMillimetre);
  fundus = InWorld(nodes[0].centre + Vector3d(0, -nodes[0].radius, 0), gallbladder_position);
  gallbladder = {"gallbladder", body, {1100, 600, 3e-3}, [body, at = nodes[5].centre] {
                   return GallbladderColour(*body, at);
                 }};

  const Trunks trunks = MakeTrunks(variant, &variation);
  const auto duct = std::make_shared<SweptBall>(trunks.duct);
  const auto artery = std::make_shared<SweptBall>(trunks.artery);
  fixed.push_back({"bile duct", duct, {700}, DuctColour});
  fixed.push_back({"hepatic artery", artery, {500}, ArteryColour});
  fixed.push_back(
      {"ligament",
       std::make_shared<SweptBall>(std::vector{Node(36, -70, -50, 5), Node(36, -80, -56, 10),
                                               Node(35, -93, -65, 13), Node(32, -106, -75, 14)}),
       {600},
       [] { return SurfaceColour(FatColour); }});
  fixed.push_back({"lymph node",
                   std::make_shared<Ellipsoid>(Point(12.5, -34.5, -19), Point(5, 3, 3),
                                               Vector3d(0.5, 0.6, -0.6), Vector3d(1, 0, 0)),
                   {200},
                   NodeColour});

  // The cystic duct leaves the neck in its own direction.
  const Vector3d end = nodes[6].centre;
  const Vector3d ahead = (end - nodes[5].centre).normalized();
  std::vector<Vector3d> way = {
      InWorld(end + (nodes[6].radius - 1 * kMillimetre) * ahead, gallbladder_position)};
  for (const Vector3d& p : CysticDuctWay(variant, &variation)) way.push_back(p);
  // From the last point straight towards the common duct, up to its surface.
  way.push_back(IntoTissue(*duct, 0.5 * way.back() + 0.5 * Union(variant), 1 * kMillimetre));
  const double duct_radius = variation.Between(1.8, 2.6) * kMillimetre;
  tubes.push_back({"cystic duct", "gallbladder", "bile duct", way, duct_radius, 0.8 * kMillimetre,
                   100e3, Vector3d(0.66, 0.50, 0.36)});

  std::vector<Vector3d> vessel = CysticArteryWay(variant, &variation);
  vessel.front() = IntoTissue(*artery, 0.3 * vessel[1] + 0.7 * vessel[0], 0.5 * kMillimetre);
  vessel.back() = InWorld(
      IntoTissue(*body, InGallbladder(vessel.back(), gallbladder_position), 1 * kMillimetre),
      gallbladder_position);
  tubes.push_back({"cystic artery", "hepatic artery", "gallbladder", vessel, 1.1 * kMillimetre,
                   0.4 * kMillimetre, 300e3, Vector3d(0.74, 0.34, 0.30)});
  leaf = FrontLeaf(*body, gallbladder_position);
}

}  // namespace hpdm
