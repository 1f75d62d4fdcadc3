#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <numbers>

#include "engine/mesh/surface_mesh.h"
#include "tools/stress/point_proxy.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

double EllipsoidVolume(const Vector3d& radii) { return 4 * std::numbers::pi / 3 * radii.prod(); }

TEST(StressTouchFixture, EllipsoidsAreClosedAndNearTheirVolume) {
  const Vector3d radii(0.05, 0.04, 0.03);
  const SurfaceMesh mesh = GeodesicEllipsoid(radii, 8);
  EXPECT_EQ(mesh.triangles.rows(), 20 * 64);
  EXPECT_EQ(mesh.vertices.rows(), 10 * 64 + 2) << "Euler: every edge has two triangles";
  // An inscribed polyhedron of edges e lacks about e^2 / 4 R^2 of a sphere: 1.2 % here.
  EXPECT_NEAR(EnclosedVolume(mesh.vertices, mesh.triangles), EllipsoidVolume(radii),
              0.02 * EllipsoidVolume(radii));
  const SurfaceMesh hollow = HollowEllipsoid(radii, 0.003, 8);
  const double wall = EllipsoidVolume(radii) - EllipsoidVolume(radii - Vector3d::Constant(0.003));
  EXPECT_NEAR(EnclosedVolume(hollow.vertices, hollow.triangles), wall, 0.02 * wall);
}

TEST(StressTouchFixture, DepthIsThatOfTheSpheresLowestPoint) {
  const StressTouchFixture fixture = SoftOrgan(StressModel::kMetricSmall, true);
  const Vector3d top = fixture.Top(0, 0.004);
  const SurfaceTree surface(fixture.rest.vertices, fixture.rest.triangles);
  for (const double depth : {-0.002, 0.0, 0.002, 0.004}) {
    // The surface there is nearly level.
    EXPECT_NEAR(Depth(surface, Below(top, depth).p_tip_W, kDefaultToolRadius), depth, 2e-5);
  }
}

TEST(PointProxy, StaysOnAStillSurfaceAndIsPastOneThatMovesBetweenSteps) {
  constexpr double kStiffness = 100;  // N/m
  const SurfaceMesh mesh = GeodesicEllipsoid(Vector3d(0.1, 0.07, 0.05), 6);
  StressTouchFixture fixture;
  fixture.rest = mesh;
  const Vector3d top = fixture.Top(0.001, 0.004);
  const SurfaceTree surface(mesh.vertices, mesh.triangles);
  PointProxy proxy(mesh, kStiffness);
  proxy.Tick(top + 0.001 * Vector3d::UnitZ());
  const Vector3d pressed = proxy.Tick(top - 0.005 * Vector3d::UnitZ());
  EXPECT_NEAR(pressed.norm(), kStiffness * 0.005, 0.01 * kStiffness * 0.005);
  EXPECT_GT(pressed.z(), 0);
  for (double x = 0; x < 0.03; x += 1e-4) {
    EXPECT_GT(proxy.Tick(fixture.Top(surface, 0.001 + x, 0.004) - 0.005 * Vector3d::UnitZ()).z(),
              0.1);
  }
  proxy.MoveSurface(0.001 * Vector3d::UnitZ());
  EXPECT_EQ(proxy.Tick(top - 0.005 * Vector3d::UnitZ()), Vector3d::Zero());
}

// Checks the results of hpdm stress for the project's own models, at each case's requested value.
TEST(HapticStress, OurSmallStrainSurvivesTheRequestedValues) {
  for (const StressCase& each : HapticStress(true)) {
    for (const StressModel model : {StressModel::kStrainSmall, StressModel::kMetricSmall}) {
      const StressTrial trial = each.run(model, each.parameter.asked);
      EXPECT_EQ(trial.fate, StressFate::kSurvived) << each.name << ": " << trial.how;
      EXPECT_EQ(trial.harm, "") << each.name;
    }
  }
}

// A force or an organ may be wrong there, but hand and tissue come to no harm.
TEST(HapticStress, OurModelsStaySafeAtTheExtremes) {
  for (const StressCase& each : HapticStress(true)) {
    for (const StressModel model : {StressModel::kStrainSmall, StressModel::kMetricFinite}) {
      const std::string harm = each.run(model, each.parameter.utmost).harm;
      EXPECT_EQ(harm, "") << each.name;
    }
  }
}

TEST(HapticStress, ABaselineFailsWhereOursDoNot) {
  for (const StressCase& each : HapticStress(true)) {
    if (each.name != "tool_inside_at_start" && each.name != "breathing_under_still_tool") continue;
    EXPECT_EQ(each.run(StressModel::kPointProxy, each.parameter.asked).fate, StressFate::kFailed)
        << each.name;
  }
}

// The readings that arrive are enough while every gap is shorter than the device's limit for a lost
// sample.
TEST(HapticStress, HalfOfTheReadingsLostCostsLittleForce) {
  for (const StressCase& each : HapticStress(true)) {
    if (each.name != "lost_samples") continue;
    const StressTrial trial = each.run(StressModel::kStrainSmall, 50);
    // A reading is one tick old on average, 50 um at 50 mm/s: 0.6 % of the 8 mm.
    EXPECT_LT(*trial.error, 0.02);
  }
}

TEST(StressSessionFixture, AToolWithFrictionIsHeldBackAlongItsSlide) {
  const StressTouchFixture fixture = SoftOrgan(StressModel::kStrainSmall, true);
  const Vector3d top = fixture.Top(0, 0.004), aside = top + 0.005 * Vector3d::UnitX();
  StressTool tool =
      OverOrgan({{0.55, Below(top, -0.01)}, {0.8, Below(top, 0.005)}, {1, Below(aside, 0.005)}});
  const double smooth = Feel(fixture, tool, 1.2).series.back().force_W.x();
  tool.tool.geometries[0].friction = 0.5;
  const double rough = Feel(fixture, tool, 1.2).series.back().force_W.x();
  EXPECT_LT(rough, smooth - 0.01);
}

}  // namespace
}  // namespace hpdm
