// Tests how a tip's contact begins, slides, sticks and ends between steps at 30 Hz.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/felt_bench.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

const Vector3d kAxes(0.1, 0.07, 0.05);  // m, half, of the ellipsoid

OrganOptions Options() {
  OrganOptions options = SoftOrgan("ellipsoid", 4);
  options.supports[0].region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)};
  return options;
}

// Moves down by `depth` into the top of the ellipsoid, at 0.05 m/s, from just above.
ToolPose PressInSession(FeltBench* bench, const Vector3d& top, double depth, double radius) {
  ToolPose tool;
  for (double z = -0.003; z < depth; z += 5e-5) {
    tool = FeltBench::At(top + Vector3d(0, 0, radius - z));
    bench->SessionTick(tool);
  }
  return tool;
}

TEST(ContactLaw, ATipThatLeavesStopsPushingWithinATick) {
  FeltBench bench(Options(), Ellipsoid(kAxes, 3));
  const Vector3d top = bench.Top(0.01, 0.005);
  ToolPose tool = PressInSession(&bench, top, 0.008, kDefaultToolRadius);
  ASSERT_GT(bench.Hand().norm(), 0.1);
  // The tip leaves at 1 m/s, 1 mm per tick. The last step still has the indentation.
  for (int tick = 1; tick <= 12; ++tick) {
    tool.X_WT.translation().z() += 0.001;
    bench.SessionTick(tool);
    const double above = tool.X_WT.translation().z() - kDefaultToolRadius - top.z();
    // The facet's plane passes at most 0.1 mm from its own top point.
    if (above > 1e-4) {
      EXPECT_EQ(bench.Hand(), Vector3d::Zero()) << above;
    } else if (above < -1e-4) {
      EXPECT_GT(bench.Hand().z(), 0) << above;
    }
  }
}

// The gallbladder's wall is 3 mm; the tip goes through its place in three ticks.
TEST(ContactLaw, APokeAtOneMetreASecondIntoAThinWallIsCaught) {
  OrganOptions options = SoftOrgan("gallbladder.obj", 4);
  options.supports[0].region = BoxFraction{Vector3d(0, 0, 0), Vector3d(1, 1, 0.27)};
  for (const double radius : {0.0, 0.0025}) {
    ToolOptions point;
    point.geometries[0].tip_radius = radius;
    FeltBench bench(options, Load(options), point);
    const Vector3d top = bench.Top(0.0013, 0.0047) + Vector3d(0, 0, radius);
    ToolPose tool = FeltBench::At(top + Vector3d(0, 0, 0.0205));
    for (int i = 0; i < 100; ++i) bench.SessionTick(tool);
    for (int tick = 0; tick < 35; ++tick) {
      tool.X_WT.translation().z() -= 0.001;
      bench.SessionTick(tool);
      const double depth = top.z() - tool.X_WT.translation().z();
      if (depth > 0) {
        EXPECT_GT(bench.Hand().z(), 0) << radius << ' ' << depth;
      }
    }
    EXPECT_GT(bench.Hand().norm(), 0.05);
  }
}

// CHAI3D's point proxy is reported to fall through fine meshes: after some ticks the tip is inside.
TEST(ContactLaw, APointTipNeitherFallsThroughAFineMeshNorSticks) {
  ToolOptions point;
  point.geometries[0].tip_radius = 0;
  FeltBench bench(Options(), Ellipsoid(kAxes, 5), point);  // edges of 4 mm
  const Vector3d top = bench.Top(0.01, 0.005);
  ToolPose tool = PressInSession(&bench, top, 0.006, 0);
  const double pressed = bench.Hand().norm();
  double least = pressed, most = pressed;
  for (int tick = 0; tick < 1500; ++tick) {  // two loops of 12 mm across the facets
    const double angle = 4 * M_PI * tick / 1500;
    const Vector3d p = top + Vector3d(0.006 * (std::cos(angle) - 1), 0.006 * std::sin(angle), 0);
    const double z = std::sqrt(1 - std::pow(p.x() / kAxes.x(), 2) - std::pow(p.y() / kAxes.y(), 2));
    tool.X_WT.translation() = Vector3d(p.x(), p.y(), kAxes.z() * z - 0.006);
    bench.SessionTick(tool);
    least = std::min(least, bench.Hand().norm());
    most = std::max(most, bench.Hand().norm());
  }
  // The stiffness of the ellipsoid varies by some per cent over the loop, and the facets lie up to
  // 0.1 mm of 6 below the ellipsoid.
  EXPECT_GT(least, 0.85 * pressed);
  EXPECT_LT(most, 1.15 * pressed);
  // The tip leaves, sideways too: it is free as soon as it is above.
  for (int tick = 0; tick < 100; ++tick) {
    tool.X_WT.translation() += Vector3d(1e-4, 0, 1e-4);
    bench.SessionTick(tool);
  }
  EXPECT_EQ(bench.Hand(), Vector3d::Zero());
}

// The surface breathes, 5 mm at 0.5 to 2 Hz, past a tip that does not move.
TEST(ContactLaw, ASurfaceThatMovesPastAStillTipIsFeltInEveryTickOfContact) {
  for (const double frequency : {0.5, 2.0}) {
    OrganOptions options = Options();
    options.motion = {Vector3d(0, 0, 0.005), frequency};
    FeltBench bench(options, Ellipsoid(kAxes, 3));
    const Vector3d top = bench.Top(0.01, 0.005);
    const double radius = kDefaultToolRadius;
    const ToolPose tool = FeltBench::At(top + Vector3d(0, 0, radius + 0.001));
    int contact = 0, missed = 0, early = 0;
    double largest_step = 0, largest = 0, last = 0;
    const int ticks = static_cast<int>(2000 / frequency);
    for (int tick = 1; tick <= ticks; ++tick) {
      bench.SessionTick(tool);
      const double raised = 0.005 * (1 - std::cos(2 * M_PI * frequency * tick * 1e-3)) / 2;
      const double force = bench.Hand().norm();
      if (raised > 0.0012) {  // the facet lies within 0.1 mm of its top point
        ++contact;
        missed += force == 0;
      } else if (raised < 0.0008) {
        early += force != 0;
      }
      largest_step = std::max(largest_step, std::abs(force - last));
      largest = std::max(largest, force);
      last = force;
    }
    EXPECT_GT(contact, ticks / 2);
    EXPECT_EQ(missed, 0);
    EXPECT_EQ(early, 0);
    // The surface moves by up to pi f 5 mm / 1000 in a tick, out of 4 mm: 0.8 % at 2 Hz; and as
    // much again while a patch is faded in.
    EXPECT_LT(largest_step, 0.016 * largest) << frequency;
  }
}

// Taps down and up at 0.3 m/s, oblique to the surface and out of step with the loop. The hand gets
// its work back, but never more.
TEST(ContactLaw, ATapGivesTheHandNoEnergy) {
  FeltBench bench(Options(), Ellipsoid(kAxes, 4));
  const Vector3d top = bench.Top(0.03, 0.02);
  const double radius = kDefaultToolRadius;
  double stored = 0, most = 0;
  Vector3d last_force = Vector3d::Zero();
  Vector3d last = top + Vector3d(0, 0, radius + 0.003);
  for (int tick = 0; tick < 3000; ++tick) {
    const double phase = 2 * M_PI * 4.7 * tick * 1e-3;
    const Vector3d p = top + Vector3d(0, 0, radius - 0.003 + 0.006 * std::cos(phase));
    bench.SessionTick(FeltBench::At(p));
    stored -= (bench.Hand() + last_force).dot(p - last) / 2;
    most = std::max(most, stored);
    last_force = bench.Hand();
    last = p;
  }
  // Fourteen taps. Patches that fade in depend on the rhythm, either way.
  EXPECT_GT(stored, -0.03 * most);
}

TEST(ContactLaw, FrictionHoldsWithinTheConeAndSlipsOnItsEdge) {
  constexpr double kFriction = 0.3;
  FeltBench bench(Options(), Ellipsoid(kAxes, 4));
  bench.friction = kFriction;
  const Vector3d top = bench.Top(0.01, 0.005);
  ToolPose tool = PressInSession(&bench, top, 0.006, kDefaultToolRadius);
  for (int i = 0; i < 200; ++i) bench.SessionTick(tool);
  const SurfaceMesh rest = Ellipsoid(kAxes, 4);
  const auto place = [&] {
    const TickContactPoint point = bench.ContactPoint();
    return SurfacePoint{point.triangle, point.weights}.Position(rest.vertices, rest.triangles);
  };
  const Vector3d held = place();
  bool slipped = false;
  double held_ticks = 0;
  for (int tick = 0; tick < 200; ++tick) {
    tool.X_WT.translation().x() += 5e-5;  // 10 mm along the surface
    bench.SessionTick(tool);
    const Vector3d force = bench.Hand(), n = bench.Felt().normal_W;
    const double normal = force.dot(n), tangential = (force - normal * n).norm();
    // 2 %: a patch's change of force is faded in and leaves the cone by so much of itself.
    EXPECT_LE(tangential, 1.02 * kFriction * normal) << tick;
    const bool moved = (place() - held).norm() > 1e-5;
    if (!moved) ++held_ticks;
    if (moved && !slipped) {
      slipped = true;
      EXPECT_GT(tangential, 0.95 * kFriction * normal) << tick;
    }
  }
  EXPECT_TRUE(slipped);
  EXPECT_GT(held_ticks, 5);
  // It slips towards the hand and pulls back on it.
  EXPECT_GT((place() - held).x(), 0.004);
  EXPECT_LT(bench.Hand().x(), 0);
}

TEST(ContactLaw, TheStepFindsTheFrictionOfTheTick) {
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    OrganOptions options = Options();
    options.lattice.cells = {3, 3, 3};
    options.energy.strain = strain;
    FeltBench bench(options, Ellipsoid(kAxes, 2));
    bench.friction = 0.3;
    ToolPose tool = bench.PressTo(bench.Top(0.01, 0.005), 0.006);
    tool.X_WT.translation().x() += 0.0005;
    for (int i = 0; i < 8; ++i) {
      bench.Step(tool);
      bench.Settle(tool);
    }
    const Vector3d n = bench.Felt().normal_W, force = bench.Hand();
    EXPECT_GT((force - force.dot(n) * n).norm(), 0.02 * force.norm());
    // 250 ticks leave e^-12 of a patch's change; the rounds converge to 1e-6.
    EXPECT_LT((force + bench.Patch().force_on_tissue_W).norm(), 1e-4 * force.norm());
  }
}

}  // namespace
}  // namespace hpdm
