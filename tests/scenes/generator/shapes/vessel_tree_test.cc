#include "scenes/generator/shapes/vessel_tree.h"

#include <gtest/gtest.h>

#include <cmath>

#include "scenes/generator/shapes/solid_noise.h"

namespace hpdm {
namespace {

constexpr double kBallRadius = 0.05;  // m
const Ellipsoid kBall(Vector3d::Zero(), Vector3d::Constant(kBallRadius));
const std::vector<std::vector<Vector3d>> kTrunk = {
    {Vector3d(0, 0, 0.05), Vector3d(0.01, 0, 0.049), Vector3d(0.02, 0, 0.046)}};
constexpr VesselOptions kOptions = {.targets = 300,
                                    .step = 2e-3,
                                    .sight = 0.04,
                                    .reached = 4e-3,
                                    .finest_radius = 0.2e-3,
                                    .seed = 9};

TEST(VesselTree, SuppliesTheWholeSurfaceAndNothingBesideIt) {
  const VesselTree tree(kBall, kTrunk, kOptions);
  RandomNumbers random(3);
  int supplied = 0;
  constexpr int kPoints = 300;
  for (int i = 0; i < kPoints; ++i) {
    Vector3d p(random.Fraction() - 0.5, random.Fraction() - 0.5, random.Fraction() - 0.5);
    p *= kBallRadius / p.norm();
    bool near = false;
    // Within two of the distances at which a target is supplied, there is a vessel.
    for (int j = 0; j < 2000 && !near; ++j) {
      const Vector3d offset(random.Fraction() - 0.5, random.Fraction() - 0.5,
                            random.Fraction() - 0.5);
      near = tree.Coverage(ProjectToLevel(kBall, p + 0.016 * offset, 0), 1e-3) > 0;
    }
    supplied += near;
    EXPECT_EQ(tree.Coverage(1.1 * p, 1e-3), 0);
    EXPECT_EQ(tree.Coverage(0.9 * p, 1e-3), 0);
  }
  // Targets are scattered: e^-1.9 = 15 % of the spots have none within 8 mm, and vessels on their
  // way pass most of those.
  EXPECT_GT(supplied, 0.9 * kPoints);
}

TEST(VesselTree, TrunksAreWiderThanTwigsByMurraysLaw) {
  const VesselTree tree(kBall, kTrunk, kOptions);
  // Width of the trunk, seen across it; it carries more than a hundred twigs, and fewer than the
  // targets: its radius is 0.2 mm times the cube root of their number.
  const Vector3d middle(0.005, 0, std::sqrt(kBallRadius * kBallRadius - 0.005 * 0.005));
  double width = 0;
  constexpr double kStep = 2e-5;
  for (double y = -4e-3; y < 4e-3; y += kStep) {
    width += kStep * (tree.Coverage(middle + Vector3d(0, y, 0), 1e-4) > 0.5);
  }
  EXPECT_GT(width, 2 * 0.2e-3 * 3);
  EXPECT_LT(width, 2 * 0.2e-3 * std::cbrt(300) + 4e-4);
}

}  // namespace
}  // namespace hpdm
