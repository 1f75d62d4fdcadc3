// The rod against closed forms: axial load, bending, shear, torsion, the elastica; its objectivity and
// its tangent.

#include "engine/duct/rod.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "engine/duct/duct_options.h"
#include "tests/support/counted_allocations.h"

namespace hpdm {
namespace {

/// A tube along the x axis of a turned frame.
struct Tube {
  std::string name;
  double length = 0.04;  // m
  double radius = 0.002;
  double wall = 0.0008;
  double young = 1e6;  // Pa
  int segments = 40;
  Vector3d turn = Vector3d::Zero();

  TubeSection section() const { return {young, radius, wall, kDuctPoisson}; }
  Matrix3d frame() const { return RotationOf(turn); }
  Vector3d World(const Vector3d& v) const { return frame() * v; }
  Rod Straight() const {
    Points path(segments + 1, 3);
    for (int i = 0; i <= segments; ++i) {
      path.row(i) = World(Vector3d(length * i / segments, 0, 0)).transpose();
    }
    return Rod(path, section());
  }
  Rod Cantilever(const Vector3d& force) const {
    Rod rod = Straight();
    rod.FreeLastEnd();
    rod.SetForce(segments, World(force));
    return rod;
  }
  // Displacement of the last node in the tube's frame.
  Vector3d Tip(const Rod& rod) const {
    return frame().transpose() * rod.node(segments) - Vector3d(length, 0, 0);
  }
};

class Tubes : public testing::TestWithParam<Tube> {};

INSTANTIATE_TEST_SUITE_P(
    Cases, Tubes,
    testing::Values(Tube{.name = "duct"},
                    Tube{.name = "artery", .radius = 0.001, .wall = 0.0003, .young = 3e5},
                    Tube{.name = "few_segments", .segments = 12},
                    Tube{.name = "many_segments", .segments = 90},
                    Tube{.name = "long", .length = 0.12},
                    Tube{.name = "turned", .turn = Vector3d(0.7, -1.9, 1.1)},
                    Tube{.name = "metres", .length = 40, .radius = 2, .wall = 0.8},
                    Tube{.name = "soft", .young = 1e3}),
    [](const auto& param_info) { return param_info.param.name; });

TEST_P(Tubes, StretchAsEA) {
  const Tube& tube = GetParam();
  const double force = 0.01 * tube.section().axial;
  Rod rod = tube.Cantilever(Vector3d(force, 0, 0));
  ASSERT_TRUE(rod.Settle(rod.rest_ends()).converged);
  const double inner = tube.radius - tube.wall;
  const double area = std::numbers::pi * (tube.radius * tube.radius - inner * inner);
  const double expected = force * tube.length / (tube.young * area);
  EXPECT_NEAR(tube.Tip(rod).x(), expected, 1e-6 * expected);
  EXPECT_NEAR(rod.ForceIn(tube.segments / 2).z(), force, 1e-6 * force);
}

// Reissner's energy in G itself has a lower state with tilted sections beyond a stretch of a quarter.
TEST_P(Tubes, StayStraightHoweverFarTheyAreStretched) {
  const Tube& tube = GetParam();
  for (const double stretch : {0.3, 1.0, 6.0}) {
    Rod rod = tube.Straight();
    std::array<Rod::Frame, 2> ends = rod.rest_ends();
    const double nudge = 1e-3 * tube.section().bending / (tube.length * tube.length);
    rod.SetForce(tube.segments / 3, tube.World(Vector3d(0, nudge, 0)));
    for (int step = 1; step <= 10; ++step) {
      ends[1].p_W =
          rod.rest_ends()[1].p_W + tube.World(Vector3d(0.1 * step * stretch * tube.length, 0, 0));
      ASSERT_TRUE(rod.Settle(ends).converged) << stretch;
    }
    const double tension = tube.section().axial * stretch;
    for (int i = 0; i < tube.segments; ++i) {
      ASSERT_NEAR(rod.ForceIn(i).z(), tension, 1e-3 * tension) << stretch << ' ' << i;
    }
  }
}

// F L^3 / (3 EI) of a slender beam, and F L / (kappa GA).
TEST_P(Tubes, BendAsEI) {
  const Tube& tube = GetParam();
  const double inner = tube.radius - tube.wall;
  const double second = std::numbers::pi * (std::pow(tube.radius, 4) - std::pow(inner, 4)) / 4;
  const double force = 0.02 * tube.young * second / (tube.length * tube.length);
  Rod rod = tube.Cantilever(Vector3d(0, 0.6 * force, -0.8 * force));
  ASSERT_TRUE(rod.Settle(rod.rest_ends()).converged);
  const double bent = force * std::pow(tube.length, 3) / (3 * tube.young * second);
  const double sheared = force * tube.length / tube.section().across;
  const Vector3d tip = tube.Tip(rod);
  EXPECT_LT((tip - (bent + sheared) * Vector3d(0, 0.6, -0.8)).norm(), 0.01 * bent);
  EXPECT_NEAR(tip.norm(), bent, 0.02 * bent) << "a beam without shear";
}

// One end displaced across by d, both directions kept: 12 EI d / L^3.
TEST_P(Tubes, ClampedAtBothEnds) {
  const Tube& tube = GetParam();
  Rod rod = tube.Straight();
  std::array<Rod::Frame, 2> ends = rod.rest_ends();
  const double way = 0.001 * tube.length;
  ends[1].p_W += tube.World(Vector3d(0, way, 0));
  ASSERT_TRUE(rod.Settle(ends).converged);
  Rod::EndVector gradient;
  Rod::EndMatrix stiffness;
  rod.Condense(&gradient, &stiffness);
  const TubeSection s = tube.section();
  const double length = tube.length;
  const double expected = way / (std::pow(length, 3) / (12 * s.bending) + length / s.across);
  EXPECT_NEAR(tube.World(Vector3d::UnitY()).dot(gradient.segment<3>(6)), expected, 0.02 * expected);
}

// Turned about its axis by an angle: GJ angle / L.
TEST_P(Tubes, TwistAsGJ) {
  const Tube& tube = GetParam();
  Rod rod = tube.Straight();
  std::array<Rod::Frame, 2> ends = rod.rest_ends();
  const Vector3d axis_W = tube.World(Vector3d::UnitX());
  ends[1].R_W = RotationOf(0.3 * axis_W) * ends[1].R_W;
  ASSERT_TRUE(rod.Settle(ends).converged);
  Rod::EndVector gradient;
  Rod::EndMatrix stiffness;
  rod.Condense(&gradient, &stiffness);
  const double expected = 0.3 * tube.section().torsion / tube.length;
  EXPECT_NEAR(axis_W.dot(gradient.segment<3>(9)), expected, 1e-3 * expected);
}

// Tip of a cantilever with a dead load F across, F L^2 / EI = a: Bisshopp and Drucker 1945
// (doi:10.1090/qam/13360), by integration of theta'' = -a cos(theta), theta(0) = theta'(1) = 0.
Eigen::Vector2d ElasticaTip(double a) {
  double low = 0, high = 20;  // theta'(0)
  Eigen::Vector2d tip = Eigen::Vector2d::Zero();
  for (int bisection = 0; bisection < 60; ++bisection) {
    const double start = (low + high) / 2;
    constexpr int kSteps = 2000;
    const double h = 1.0 / kSteps;
    double theta = 0, slope = start;
    tip.setZero();
    for (int i = 0; i < kSteps; ++i) {
      // Midpoint rule.
      const double middle = theta + h / 2 * slope,
                   middle_slope = slope - h / 2 * a * std::cos(theta);
      tip += h * Eigen::Vector2d(std::cos(middle), std::sin(middle));
      theta += h * middle_slope;
      slope -= h * a * std::cos(middle);
    }
    (slope > 0 ? high : low) = start;
  }
  return tip;
}

TEST(Elastica, TheReferenceHasThePublishedTip) {
  // Mattiasson 1981 (doi:10.1002/nme.1620170113): F L^2 / EI = 1 and 10.
  EXPECT_NEAR(ElasticaTip(1).y(), 0.30172, 2e-5);
  EXPECT_NEAR(1 - ElasticaTip(1).x(), 0.05643, 2e-5);
  EXPECT_NEAR(ElasticaTip(10).y(), 0.81061, 2e-5);
  EXPECT_NEAR(1 - ElasticaTip(10).x(), 0.55500, 2e-5);
}

// Thin tubes: the elastica has neither shear nor stretch.
TEST(Elastica, LargeDeflectionsAreItsOwn) {
  for (const int segments : {20, 40, 80}) {
    for (const double a : {0.5, 1.0, 2.0, 5.0, 10.0}) {
      const Tube tube{.name = "thin",
                      .radius = 0.0006,
                      .wall = 0.0002,
                      .segments = segments,
                      .turn = Vector3d(-0.4, 0.9, 2.0)};
      const double force = a * tube.section().bending / (tube.length * tube.length);
      Rod rod = tube.Cantilever(Vector3d(0, 0, force));
      ASSERT_TRUE(rod.Settle(rod.rest_ends()).converged);
      const Eigen::Vector2d expected = tube.length * ElasticaTip(a);
      const Vector3d tip = tube.Tip(rod) + Vector3d(tube.length, 0, 0);
      EXPECT_NEAR(tip.z(), expected.y(), 0.02 * expected.y()) << segments << " " << a;
      EXPECT_NEAR(tip.x(), expected.x(), 0.02 * tube.length) << segments << " " << a;
      EXPECT_NEAR(tip.y(), 0, 1e-6 * tube.length);
    }
  }
}

/// A curved rod between ends that have moved far.
struct Moved {
  Moved() : rod(Path(), TubeSection(4e5, 0.002, 0.0006, kDuctPoisson)), ends(rod.rest_ends()) {
    ends[0].p_W += Vector3d(0.002, -0.001, 0.003);
    ends[0].R_W = RotationOf(Vector3d(0.3, 0.2, -0.5)) * ends[0].R_W;
    ends[1].p_W += Vector3d(0.004, 0.006, 0.002);
    ends[1].R_W = RotationOf(Vector3d(-0.2, 0.6, 0.4)) * ends[1].R_W;
    EXPECT_TRUE(rod.Settle(ends).converged);
    rod.Condense(&gradient, &stiffness);
  }
  static Points Path() {
    Points path(31, 3);
    for (int i = 0; i <= 30; ++i) {
      const double s = i / 30.0;
      path.row(i) << 0.03 * s, 0.006 * std::sin(3 * s), 0.004 * s * s;
    }
    return path;
  }

  Rod rod;
  std::array<Rod::Frame, 2> ends;
  Rod::EndVector gradient;
  Rod::EndMatrix stiffness;
};

TEST(Rod, IsAtRestOnItsPath) {
  Rod rod(Moved::Path(), TubeSection(4e5, 0.002, 0.0006, kDuctPoisson));
  const Rod::Result result = rod.Settle(rod.rest_ends());
  EXPECT_EQ(result.iterations, 0);
  EXPECT_LT(rod.Energy(), 1e-18);
}

TEST(Rod, TheForcesOfTheEndsAreInBalance) {
  const Moved moved;
  const Vector3d force_a = moved.gradient.segment<3>(0), force_b = moved.gradient.segment<3>(6);
  EXPECT_GT(force_a.norm(), 1e-3);
  EXPECT_LT((force_a + force_b).norm(), 1e-6 * force_a.norm());
  const Vector3d moment = moved.gradient.segment<3>(3) + moved.gradient.segment<3>(9) +
                          moved.ends[0].p_W.cross(force_a) + moved.ends[1].p_W.cross(force_b);
  EXPECT_LT(moment.norm(), 1e-6 * moved.gradient.segment<3>(3).norm());
}

TEST(Rod, ForcesAndTangentAreTheEnergysDerivatives) {
  const Moved moved;
  for (int k = 0; k < 12; ++k) {
    const bool turns = (k / 3) % 2 == 1;
    const double step = turns ? 1e-4 : 1e-6;
    const Vector3d way = step * Vector3d::Unit(k % 3);
    std::array<double, 2> energies{};
    std::array<Rod::EndVector, 2> gradients;
    for (std::size_t side = 0; side < 2; ++side) {
      Rod rod = moved.rod;
      std::array<Rod::Frame, 2> ends = moved.ends;
      Rod::Frame& end = ends[static_cast<std::size_t>(k / 6)];
      const Vector3d moved_way = side == 0 ? Vector3d(-way) : way;
      if (turns) end.R_W = RotationOf(moved_way) * end.R_W;
      if (!turns) end.p_W += moved_way;
      ASSERT_TRUE(rod.Settle(ends).converged);
      energies[side] = rod.Energy();
      Rod::EndMatrix unused;
      rod.Condense(&gradients[side], &unused);
    }
    const double slope = (energies[1] - energies[0]) / (2 * step);
    EXPECT_NEAR(moved.gradient[k], slope, 1e-4 * moved.gradient.segment<3>(3 * (k / 3)).norm())
        << k;
    // A rotation's tangent is symmetric only up to the moments there.
    if (turns) continue;
    const Rod::EndVector column = (gradients[1] - gradients[0]) / (2 * step);
    EXPECT_LT((column - moved.stiffness.col(k)).norm(), 2e-3 * column.norm()) << k;
  }
}

TEST(Rod, ARigidMotionChangesNothing) {
  const Moved moved;
  const Matrix3d R = RotationOf(Vector3d(1.2, -0.8, 2.1));
  const Vector3d way(0.1, -0.3, 0.2);
  Points path = Moved::Path() * R.transpose();
  path.rowwise() += way.transpose();
  Rod rod(path, TubeSection(4e5, 0.002, 0.0006, kDuctPoisson));
  std::array<Rod::Frame, 2> ends = rod.rest_ends();
  for (std::size_t e = 0; e < 2; ++e) {
    const Matrix3d turned = moved.ends[e].R_W * moved.rod.rest_ends()[e].R_W.transpose();
    ends[e] = {R * moved.ends[e].p_W + way, R * turned * R.transpose() * rod.rest_ends()[e].R_W};
  }
  ASSERT_TRUE(rod.Settle(ends).converged);
  EXPECT_NEAR(rod.Energy(), moved.rod.Energy(), 1e-7 * moved.rod.Energy());
  for (int i = 0; i < rod.nodes(); ++i) {
    EXPECT_LT((rod.node(i) - (R * moved.rod.node(i) + way)).norm(), 1e-8) << i;
  }
}

// The same rod after a rigid motion of both ends in steps: no force remains.
TEST(Rod, FollowsEndsThatTurnTogether) {
  Rod rod(Moved::Path(), TubeSection(4e5, 0.002, 0.0006, kDuctPoisson));
  std::array<Rod::Frame, 2> ends = rod.rest_ends();
  for (int step = 0; step < 40; ++step) {
    const Matrix3d R = RotationOf(Vector3d(0.05, 0.1, -0.02));
    for (Rod::Frame& end : ends) {
      end.p_W = R * end.p_W;
      end.R_W = R * end.R_W;
    }
    ASSERT_TRUE(rod.Settle(ends).converged) << step;
    EXPECT_LT(rod.Energy(), 1e-12) << step;
  }
}

TEST(Rod, ACutSeparatesItsParts) {
  Moved moved;
  ASSERT_TRUE(moved.rod.Cut(12));
  ASSERT_TRUE(moved.rod.Settle(moved.ends).converged);
  EXPECT_EQ(moved.rod.nodes(), 32);
  EXPECT_FALSE(moved.rod.IsSegment(12));
  EXPECT_LT(moved.rod.Energy(), 1e-12) << "both parts hang free of force";
  moved.rod.Condense(&moved.gradient, &moved.stiffness);
  EXPECT_LT(moved.gradient.norm(), 1e-6);
  EXPECT_LT(moved.stiffness.norm(), 1e-3) << "N/m";
  EXPECT_GT((moved.rod.node(13) - moved.rod.node(12)).norm(), 1e-3);
  EXPECT_FALSE(moved.rod.Cut(13)) << "beside the gap";
  EXPECT_FALSE(moved.rod.Cut(1)) << "beside the end";
}

TEST(Rod, AHeldNodeStaysWhereItIsHeld) {
  const Tube tube{.name = "duct"};
  Rod rod = tube.Straight();
  const Vector3d target_W(0.02, 0, 0.004);
  rod.Hold(20, target_W);
  ASSERT_TRUE(rod.Settle(rod.rest_ends()).converged);
  EXPECT_EQ(rod.node(20), target_W);
  Rod::EndVector gradient;
  Rod::EndMatrix stiffness;
  rod.Condense(&gradient, &stiffness);
  const Vector3d sum = gradient.segment<3>(0) + gradient.segment<3>(6) + rod.HoldingForce(20);
  EXPECT_LT(sum.norm(), 1e-6 * rod.HoldingForce(20).norm()) << "third law";
  rod.Release(20);
  ASSERT_TRUE(rod.Settle(rod.rest_ends()).converged);
  EXPECT_LT(rod.Energy(), 1e-12);
}

TEST(Rod, StepsAllocateNothing) {
  if (!kCountsAllocations) GTEST_SKIP() << "the sanitizer's allocator";
  Moved moved;
  const long before = AllocationsOfThisThread();
  for (int step = 0; step < 20; ++step) {
    moved.ends[1].p_W.x() -= 0.0005;
    moved.rod.Settle(moved.ends);
    moved.rod.Condense(&moved.gradient, &moved.stiffness);
    if (step == 10) moved.rod.Cut(10);
  }
  EXPECT_EQ(AllocationsOfThisThread(), before);
}

}  // namespace
}  // namespace hpdm
