#include "tools/haptics/organ_trials.h"

#include <gtest/gtest.h>

#include <numbers>

#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

SurfaceMesh SphereAt(double radius, double x) {
  Isometry3d X_WO = Isometry3d::Identity();
  X_WO.translation().x() = x;
  return Ellipsoid(Vector3d::Constant(radius), 4, X_WO);
}

Penetration Measured(const SurfaceMesh& first, const SurfaceMesh& second) {
  PenetrationMeter meter;
  meter.Measure(first, second);
  return meter.result();
}

// Two spheres that overlap by d: the depth in the other one is about d (1 - r^2 / a^2), with
// a^2 = R d: its mean is d / 2. Facets of 2 mm lie up to 0.03 mm below the sphere.
TEST(PenetrationMeter, FindsTheDepthOfTwoSpheres) {
  for (const double overlap : {0.001, 0.002, 0.003}) {
    const Penetration found = Measured(SphereAt(0.02, 0), SphereAt(0.02, 0.04 - overlap));
    EXPECT_NEAR(found.largest, overlap, 8e-5);
    EXPECT_NEAR(found.mean, overlap / 2, 8e-5);
    EXPECT_NEAR(found.touching, 2 * std::numbers::pi * 0.02 * overlap,
                0.15 * 2 * std::numbers::pi * 0.02 * overlap);
  }
}

TEST(PenetrationMeter, FindsNothingBetweenOrgansThatAreApart) {
  const Penetration found = Measured(SphereAt(0.02, 0), SphereAt(0.02, 0.0401));
  EXPECT_EQ(found.largest, 0);
  EXPECT_EQ(found.touching, 0);
}

// A shell's cavity is not tissue, but what is in it went through the wall. The ball's surface lies 15 mm
// below the outer sphere.
TEST(PenetrationMeter, CountsWhatWentThroughAWall) {
  SurfaceMesh shell = SphereAt(0.02, 0), inner = SphereAt(0.017, 0);
  inner.triangles.col(1).swap(inner.triangles.col(2));
  inner.triangles.array() += static_cast<int>(shell.vertices.rows());
  SurfaceMesh hollow;
  hollow.vertices.resize(2 * shell.vertices.rows(), 3);
  hollow.vertices << shell.vertices, inner.vertices;
  hollow.triangles.resize(2 * shell.triangles.rows(), 3);
  hollow.triangles << shell.triangles, inner.triangles;
  EXPECT_NEAR(Measured(SphereAt(0.005, 0), hollow).largest, 0.015, 1e-4);
}

TEST(OrganTrials, PressedBarsHaveTheForceOfTheirSeries) {
  const BarsPress press = PressBars({.young_below = 5000, .young_above = 8000});
  EXPECT_NEAR(press.force, 1, 0.01);
  EXPECT_LT(press.flatness, 0.01);
  EXPECT_LT(press.third_law, 1e-12);
}

}  // namespace
}  // namespace hpdm
