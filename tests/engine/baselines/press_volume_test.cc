#include "engine/baselines/press_volume.h"

#include <gtest/gtest.h>

#include <limits>

#include "engine/baselines/mass_spring.h"
#include "engine/baselines/surface_continuum.h"
#include "engine/baselines/surface_error.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const SurfaceMesh& SphereMesh() {
  static const SurfaceMesh mesh = Ellipsoid(Vector3d::Constant(0.1), 3);
  return mesh;
}

Eigen::VectorXd Ground() {
  const SupportOptions below{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.3)}, {}};
  return GroundSprings(SphereMesh(), MeasureSkin(SphereMesh(), "ball"), {below}, 2000, "ball");
}

SurfacePress Top(double depth) {
  SurfacePress press;
  double highest = 0;
  for (int t = 0; t < SphereMesh().triangles.rows(); ++t) {
    const SurfacePoint centre{t, Vector3d::Constant(1. / 3)};
    const double z = centre.Position(SphereMesh().vertices, SphereMesh().triangles).z();
    if (z <= highest) continue;
    highest = z;
    press.at = centre;
  }
  press.radius = 0.03;
  press.depth = depth;
  return press;
}

PressOutcome PressContinuum(const SurfacePress& press) {
  SurfaceContinuumOptions options;
  options.time_step = std::numeric_limits<double>::infinity();
  SurfaceContinuum model(SphereMesh(), Ground(), options, "ball");
  return MeasurePress(SphereMesh(), VertexWeights(SphereMesh().vertices.rows()), press, 1, 0,
                      &model);
}

TEST(PressVolume, ChangeOfAScaledBodyIsThatOfTheCube) {
  EXPECT_NEAR(RelativeVolumeChange(SphereMesh(), 0.01 * SphereMesh().vertices),
              1.01 * 1.01 * 1.01 - 1,
              1e-12);  // round-off
  EXPECT_EQ(RelativeVolumeChange(SphereMesh(), 0 * SphereMesh().vertices), 0);
}

TEST(PressVolume, PatchIsNormalisedAndFallsBackToThePoint) {
  const SurfacePress press = Top(0);
  const Eigen::RowVectorXd wide = PatchWeights(SphereMesh(), press.at, 0.03);
  EXPECT_NEAR(wide.sum(), 1, 1e-12);
  EXPECT_GE(wide.minCoeff(), 0);
  EXPECT_GT((wide.array() > 0).count(), 6);  // edges are about 15 mm
  const Eigen::RowVectorXd point = PatchWeights(SphereMesh(), press.at, 0.001);
  EXPECT_EQ((point.array() > 0).count(), 3);
}

TEST(PressVolume, NoPressChangesNothing) {
  const PressOutcome outcome = PressContinuum(Top(0));
  EXPECT_EQ(outcome.volume_change, 0);
  EXPECT_EQ(outcome.force_W.norm(), 0);
}

TEST(PressVolume, PatchGoesToItsDepthAndVolumeIsLost) {
  const double depth = 0.015;
  const SurfacePress press = Top(depth);
  const PressOutcome outcome = PressContinuum(press);
  const Eigen::RowVectorXd patch = PatchWeights(SphereMesh(), press.at, press.radius);
  const Vector3d moved = patch * (outcome.vertices - SphereMesh().vertices);
  EXPECT_NEAR(moved.norm(), depth, 1e-9);  // the contacts' padding
  // At least the cone of that depth over the patch, of the ball's volume; nothing keeps it.
  EXPECT_LT(outcome.volume_change, -0.25 * 0.03 * 0.03 * depth / (4 * 0.1 * 0.1 * 0.1));
  EXPECT_LT(outcome.force_W.dot(Vector3d(patch * SphereMesh().vertices)), 0);  // pushes inwards
}

TEST(PressVolume, SpringsToRestKeepThePressLocalAndStiffen) {
  const auto press = [](double home) {
    MassSpringOptions options;
    options.home = home;
    MassSpring model(SphereMesh(), Ground(), options, "ball");
    return MeasurePress(SphereMesh(), VertexWeights(SphereMesh().vertices.rows()), Top(0.01), 10,
                        60, &model);
  };
  const auto spread = [](const PressOutcome& outcome) {
    return (outcome.vertices - SphereMesh().vertices).rowwise().norm().mean();
  };
  const PressOutcome free = press(0), held = press(1e6);
  EXPECT_LT(spread(held), spread(free));
  EXPECT_GT(held.force_W.norm(), free.force_W.norm());
}

}  // namespace
}  // namespace hpdm
