#include "tools/stress/stress_session_fixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <numbers>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

constexpr double kTop = 0.05;  // m, of the ellipsoid

StressPose At(double x, double z, double jaw = 1, double roll = 0) {
  return {.p_tip_W = Vector3d(x, 0, z), .roll = roll, .jaw = jaw};
}

// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes, held in its lower quarter.
OrganOptions Organ(StrainMeasure strain, EnergyType energy = EnergyType::kStrain) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = energy;
  options.energy.strain = strain;
  options.energy.alpha = 500;
  options.lattice.cells = {3, 3, 3};
  options.lattice.local.functions = 0;
  options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
  return options;
}

std::vector<OrganOptions> AllModels() {
  std::vector<OrganOptions> all;
  for (const EnergyType energy : {EnergyType::kStrain, EnergyType::kMetric}) {
    for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
      all.push_back(Organ(strain, energy));
    }
  }
  all.push_back(Organ(StrainMeasure::kFinite));
  all.back().energy.law = MaterialLaw::kStVenantKirchhoff;
  all.push_back(Organ(StrainMeasure::kSmall));
  all.back().lattice.local.functions = 20;
  all.push_back(Organ(StrainMeasure::kSmall));
  all.back().lattice.basis = BasisType::kBernstein;
  all.back().lattice.degree = {3, 3, 3};
  all.back().lattice.cells = {1, 1, 1};
  return all;
}

SurfaceMesh Surface() { return Ellipsoid(Vector3d(0.1, 0.07, 0.05), 3); }

StressTool Hand(std::vector<std::pair<double, StressPose>> way, double x_trocar = 0.02) {
  StressTool tool;
  tool.motion = Through(std::move(way));
  tool.p_trocar_W = Vector3d(x_trocar, 0.01, 0.4);
  tool.tool.geometries[0].can_grasp = true;
  return tool;
}

// Grasps the top at x (jaws closed by 0.6 s), goes to `far` within a step, opens and is away at 1
// s.
StressTool Grasp(double x, const StressPose& far, double x_trocar = 0.02) {
  const double at = kTop + kDefaultToolRadius;
  return Hand({{0, At(x, at)},
               {0.45, At(x, at)},
               {0.5, At(x, at, 0)},
               {0.6, At(x, at, 0)},
               {0.6, far},
               {1, far},
               {1, At(x, at + 0.02)}},
              x_trocar);
}

// A ball of 20 mm that goes `depth` deep within a step, and back at 1 s.
StressTool Ball(double depth) {
  constexpr double kRadius = 0.02;
  const StressPose away = At(0, kTop + kRadius + 0.01), deep = At(0, kTop + kRadius - depth);
  StressTool tool = Hand({{0, away}, {0.6, away}, {0.6, deep}, {1, deep}, {1, away}});
  tool.tool.geometries[0].tip_radius = kRadius;
  return tool;
}

void ExpectHarmless(const StressOutcome& outcome, double released) {
  EXPECT_EQ(Harm(outcome, released), "");
  EXPECT_LT(outcome.displacement, StressSessionFixture::kAtRest);
}

TEST(StressSessionFixture, GoesThroughItsWaypoints) {
  const auto motion = Through({{1, At(0, 1)}, {2, At(0, 3, 0)}, {2, At(1, 3)}, {4, At(1, 1)}});
  EXPECT_EQ(motion(0).p_tip_W, Vector3d(0, 0, 1));
  EXPECT_EQ(motion(1.5).p_tip_W, Vector3d(0, 0, 2));
  EXPECT_EQ(motion(1.5).jaw, 0.5);
  EXPECT_EQ(motion(2).p_tip_W, Vector3d(1, 0, 3));
  EXPECT_EQ(motion(3).p_tip_W, Vector3d(1, 0, 2));
  EXPECT_EQ(motion(9).p_tip_W, Vector3d(1, 0, 1));
}

TEST(StressSessionFixture, MeasuresWhatAGentlePressDoes) {
  const double at = kTop + kDefaultToolRadius;
  StressSessionFixture body(Organ(StrainMeasure::kSmall), Surface(),
                            {Hand({{0, At(0, at + 0.01)}, {0.8, At(0, at - 0.01)}})});
  body.RunUntil(1.2);
  const StressOutcome& outcome = body.outcome();
  EXPECT_EQ(outcome.steps, 35) << "36 began, and the last is not visible yet";
  EXPECT_EQ(outcome.flags, kStepOk);
  EXPECT_EQ(outcome.inverted_share, 0);
  EXPECT_NEAR(outcome.force, body.tick().tools[0].force_W.norm(), 1e-3) << "it holds";
  EXPECT_GT(outcome.force, 0.1);
  EXPECT_NEAR(outcome.force, outcome.tissue_force, 0.02 * outcome.force);
  EXPECT_GT(outcome.displacement, 1e-4);
  EXPECT_NEAR(outcome.last_off_rest, 35. / 30, 0.04);
}

class StressSessionFixtureOfModel : public testing::TestWithParam<OrganOptions> {};

TEST_P(StressSessionFixtureOfModel, ComesBackFromAGraspThroughItselfAsIfNothingHadBeen) {
  StressSessionFixture body(GetParam(), Surface(), {Grasp(0, At(0, -0.08, 0))});
  body.RunUntil(1.3);
  ExpectHarmless(body.outcome(), 1);
  if (GetParam().energy.strain == StrainMeasure::kFinite) {
    EXPECT_EQ(body.outcome().inverted_share, 0)
        << "an inverting step is rejected before it is shown";
  } else if (body.outcome().inverted_share > 0) {
    EXPECT_NE(body.outcome().flags & kStepInverted, 0u);
  }
  EXPECT_EQ(body.step().step.flags, kStepOk);
}

TEST_P(StressSessionFixtureOfModel, ComesBackFromABallThroughTheOrgan) {
  StressSessionFixture body(GetParam(), Surface(), {Ball(0.09)});
  body.RunUntil(1.3);
  ExpectHarmless(body.outcome(), 1);
  EXPECT_EQ(body.step().step.flags, kStepOk);
}

INSTANTIATE_TEST_SUITE_P(Models, StressSessionFixtureOfModel, testing::ValuesIn(AllModels()));

// Both jaws hold the same tissue at the top, or tissue within one cell, which rigid jaws leave no
// freedom.
TEST(StressSessionFixture, TwoToolsThatPullTheSamePointApartSlip) {
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    for (const double x : {0.001, 0.015}) {
      StressSessionFixture body(
          Organ(strain), Surface(),
          {Grasp(-x, At(-0.06, 0.08, 0), -0.02), Grasp(x, At(0.06, 0.08, 0))});
      body.RunUntil(1.3);
      ExpectHarmless(body.outcome(), 1);
      // 5e9 N without slip; E L^2 of the organ is 5000 Pa (0.2 m)^2 = 200 N.
      EXPECT_LT(body.outcome().tissue_force, 1000);
      EXPECT_LT(body.outcome().reaction, 1000) << "before the guard";
    }
  }
}

// Viscoelastic tissue pulled within a step feels up to ten times the force that remains.
TEST(StressSessionFixture, ViscousTissueAnswersASmallWayAlikeInSmallAndFiniteStrain) {
  constexpr double kWay = 0.005;  // m
  std::vector<double> forces;
  for (const StrainMeasure strain : {StrainMeasure::kSmall, StrainMeasure::kFinite}) {
    OrganOptions options = Organ(strain);
    options.material.prony = {.count = 1, .terms = {{{.share = 0.9, .time = 10}}}};
    const double at = kTop + kDefaultToolRadius;
    StressSessionFixture body(options, Surface(), {Grasp(0, At(0, at - kWay, 0))});
    body.RunUntil(1);
    forces.push_back(body.outcome().tissue_force);
    EXPECT_LT(body.outcome().largest_displacement, 1.2 * kWay) << "what bulges beside the jaws";
    EXPECT_EQ(body.outcome().flags & (kStepInverted | kStepRecovering), 0u);
  }
  // The motion is a tenth of the organ's thickness: strains of some percent.
  EXPECT_NEAR(forces[1] / forces[0], 1, 0.1);
}

// A level shaft lies on the tissue beside the grasped part, which moves with it: if the shaft
// pushed it, it would pull at the jaws with 23 N. Edges are 3 mm, so that some of it is held.
TEST(StressSessionFixture, AGraspFeelsNothingOfItsOwnShaftBesideIt) {
  const auto largest_force = [](double shaft_radius) {
    const double in = kTop - 0.0025;
    StressTool tool = Hand({{0, At(0, in + 0.02)},
                            {0.4, At(0, in)},
                            {0.45, At(0, in)},
                            {0.5, At(0, in, 0)},
                            {0.6, At(0, in, 0)},
                            {0.9, At(-0.01, in - 0.003, 0)}});
    tool.p_trocar_W = Vector3d(0.35, 0.01, kTop + 0.01);
    tool.tool.geometries[0].shaft_radius = shaft_radius;
    StressSessionFixture body(Organ(StrainMeasure::kSmall), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 5),
                              {tool});
    body.RunUntil(1);
    return body.outcome().tissue_force;
  };
  // The shaft holds down the tissue farther along: more of it moves.
  EXPECT_LT(largest_force(kDefaultToolRadius), 2 * largest_force(1e-4));
}

TEST(StressSessionFixture, AReadingThatIsNotFiniteHoldsTheTool) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const double at = kTop + kDefaultToolRadius;
  const StressPose pressed = At(0, at - 0.01), away = At(0, at + 0.01);
  StressSessionFixture body(Organ(StrainMeasure::kFinite), Surface(),
                            {Hand({{0, away},
                                   {0.5, pressed},
                                   {0.8, pressed},
                                   {0.8, At(kNan, kNan)},
                                   {0.9, At(kNan, kNan)},
                                   {0.9, pressed},
                                   {1, pressed},
                                   {1, away}})});
  body.RunUntil(1.3);
  ExpectHarmless(body.outcome(), 1);
}

// A finite-strain organ that could not follow recovers when the demand falls, and keeps no memory:
// it ends in the state of an organ that only got the lower demand.
TEST(StressSessionFixture, ASmallPressIsFollowedAfterAnImpossibleOne) {
  constexpr double kJaws = 0.02;  // m: wide enough to invert what they pull through itself
  const double at = kTop + kJaws;
  const StressPose little = At(0, at + 0.004, 0);
  const auto grasp_then = [&](const StressPose& much) {
    StressTool tool = Hand({{0, At(0, at)},
                            {0.45, At(0, at)},
                            {0.5, At(0, at, 0)},
                            {0.6, At(0, at, 0)},
                            {0.6, much},
                            {1, much},
                            {1.1, little}});
    tool.tool.geometries[0].tip_radius = kJaws;
    tool.tool.geometries[0].closing_force = 1e6;  // nothing slips
    return tool;
  };
  for (const MaterialLaw law : {MaterialLaw::kNeoHookean, MaterialLaw::kStVenantKirchhoff}) {
    OrganOptions options = Organ(StrainMeasure::kFinite);
    options.energy.law = law;
    StressSessionFixture spoilt(options, Surface(), {grasp_then(At(0, -0.08, 0))});
    StressSessionFixture fresh(options, Surface(), {grasp_then(little)});
    spoilt.RunUntil(0.9);
    EXPECT_NE(spoilt.step().step.flags & kStepRecovering, 0u);
    spoilt.RunUntil(1.6);
    fresh.RunUntil(1.6);
    EXPECT_EQ(spoilt.step().step.flags & (kStepRecovering | kStepInverted), 0u);
    EXPECT_EQ(fresh.outcome().flags & (kStepRecovering | kStepInverted), 0u);
    // Newton's tolerance and more: the last of its steps changes 1e-6 of the load.
    EXPECT_LT((spoilt.state().vertices - fresh.state().vertices).rowwise().norm().maxCoeff(), 1e-5);
  }
}

}  // namespace
}  // namespace hpdm
