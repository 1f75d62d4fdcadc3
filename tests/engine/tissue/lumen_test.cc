#include "engine/tissue/lumen.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>

#include "engine/base/error.h"
#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

// A ball with two round cavities, of 10 and 5 mm radius.
SurfaceMesh BallWithTwoCavities() {
  SurfaceMesh large = Reversed(MakeSphere(3, 0.01)), small = Reversed(MakeSphere(3, 0.005));
  large.vertices.rowwise() += Eigen::RowVector3d(-0.015, 0, 0);
  small.vertices.rowwise() += Eigen::RowVector3d(0.015, 0, 0);
  return Joined(MakeSphere(3, 0.04), Joined(large, small));
}

OrganOptions BallWith(std::vector<LumenOptions> lumens) {
  OrganOptions organ;
  organ.name = "ball";
  organ.lumens = std::move(lumens);
  return organ;
}

double BallVolume(double radius) { return 4.0 / 3 * std::numbers::pi * std::pow(radius, 3); }

std::string LumenRefusal(const SurfaceMesh& rest, const LumenOptions& lumen) {
  try {
    FilledLumens(rest, BallWith({lumen}));
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Lumen, EveryClosedCavityIsOneOfItsVolume) {
  const std::vector<Lumen> lumens = FilledLumens(BallWithTwoCavities(), BallWith({{}}));
  ASSERT_EQ(lumens.size(), 2);
  EXPECT_NEAR(lumens[0].volume, BallVolume(0.01), 0.03 * BallVolume(0.01));
  EXPECT_NEAR(lumens[1].volume, BallVolume(0.005), 0.03 * BallVolume(0.005));
  EXPECT_EQ(lumens[0].bulk_modulus, 2.2e9);
}

TEST(Lumen, ALaterTableEmptiesOneOfThem) {
  LumenOptions soft, empty;
  soft.bulk_modulus = 7;
  empty.region = Sphere{Vector3d(-0.015, 0, 0), 0.012};
  empty.filled = false;
  const std::vector<Lumen> lumens = FilledLumens(BallWithTwoCavities(), BallWith({soft, empty}));
  ASSERT_EQ(lumens.size(), 1);
  EXPECT_LT(lumens[0].volume, BallVolume(0.006));
  EXPECT_EQ(lumens[0].bulk_modulus, 7);
}

TEST(Lumen, VolumeChangesWithTheWallAndNotWithThePlace) {
  const SurfaceMesh ball = BallWithTwoCavities();
  for (const Lumen& lumen : FilledLumens(ball, BallWith({{}}))) {
    Points moved = ball.vertices;
    moved.rowwise() = Eigen::RowVector3d(1, -2, 3);
    EXPECT_NEAR(RelativeChange(lumen, moved), 0, 1e-12 / lumen.volume);
    // Half of a per cent along each axis, about any centre.
    EXPECT_NEAR(RelativeChange(lumen, 0.005 * ball.vertices), 0.015, 1e-12);
    // A rotation, to first order.
    moved = ball.vertices;
    for (Eigen::Index v = 0; v < moved.rows(); ++v) {
      moved.row(v) = Vector3d(1, 2, 3).cross(Vector3d(ball.vertices.row(v)));
    }
    EXPECT_NEAR(RelativeChange(lumen, moved), 0, 1e-9);
  }
}

TEST(Lumen, AnOpenOneIsRefusedWithItsPlace) {
  const SurfaceMesh outer = MakeSphere(3, 0.04);
  const SurfaceMesh open = Joined(outer, Without(Reversed(MakeSphere(2, 0.01)), 0, 1));
  const std::string message = LumenRefusal(open, {});
  EXPECT_NE(message.find("lumen[0] is open at [-0.00"), std::string::npos) << message;
  EXPECT_NE(LumenRefusal(outer, {}).find("no closed lumen"), std::string::npos);
  LumenOptions elsewhere;
  elsewhere.region = Sphere{Vector3d(0.1, 0, 0), 0.01};
  EXPECT_NE(LumenRefusal(BallWithTwoCavities(), elsewhere).find("no closed lumen"),
            std::string::npos);
}

TEST(Lumen, TheOuterSurfaceIsNone) {
  const SurfaceMesh ball = BallWithTwoCavities();
  const std::vector<bool> inner = TrianglesOfLumens(ball);
  const auto outer = static_cast<std::size_t>(MakeSphere(3).triangles.rows());
  for (std::size_t t = 0; t < inner.size(); ++t) EXPECT_EQ(inner[t], t >= outer) << t;
}

}  // namespace
}  // namespace hpdm
