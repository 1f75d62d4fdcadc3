#include "engine/step/strain_blend_controller.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

constexpr double kBound = 0.3;
constexpr double kSlope = 0.1;  // dE/ds over E
constexpr QualityCeiling kNothingShed;

OrganOptions ControllerOptions(StrainMeasure strain) {
  OrganOptions options;
  options.energy.type = EnergyType::kStrain;
  options.energy.strain = strain;
  options.energy.finite_from = kBound;
  options.energy.newton_iterations = 4;
  options.lattice.local.functions = 4;
  return options;
}

class StrainBlendControllerTest : public testing::Test {
 protected:
  explicit StrainBlendControllerTest(StrainMeasure strain = StrainMeasure::kAdaptive)
      : controller_(ControllerOptions(strain)) {}

  double Share(double gradient, const QualityCeiling& ceiling = kNothingShed, bool touched = true) {
    return controller_.Next(ceiling, touched, gradient, kSlope).finite_strain_blend;
  }
  // Returns the share after more steps than any change takes.
  double InTheEnd(double gradient, const QualityCeiling& ceiling = kNothingShed) {
    for (int step = 0; step < 1000; ++step) Share(gradient, ceiling);
    return Share(gradient, ceiling);
  }

  StrainBlendController controller_;
};

class FiniteStrainBlendTest : public StrainBlendControllerTest {
 protected:
  FiniteStrainBlendTest() : StrainBlendControllerTest(StrainMeasure::kFinite) {}
};

TEST_F(StrainBlendControllerTest, AdaptiveStrainIsSmallBelowTheBoundAndFiniteBeyond) {
  EXPECT_EQ(InTheEnd(0.99 * kBound), 0);
  EXPECT_EQ(InTheEnd(1.01 * kBound), 1);
}

TEST_F(StrainBlendControllerTest, BetweenTheBoundsItStaysAsItIs) {
  const double between = 0.9 * kBound;
  EXPECT_EQ(InTheEnd(between), 0);
  InTheEnd(1.01 * kBound);
  EXPECT_EQ(InTheEnd(between), 1);
  EXPECT_EQ(InTheEnd(0.79 * kBound), 0);
}

TEST_F(StrainBlendControllerTest, AStepMovesTheForceByNoMoreThanItsShare) {
  double last = Share(1.01 * kBound);
  EXPECT_EQ(last, StrainBlendController::kFirstStep);
  for (double share = 0; last < 1; last = share) {
    share = Share(1.01 * kBound);
    EXPECT_LE((share - last) * kSlope * StrainBlendController::kForceOverEnergy,
              1.01 * StrainBlendController::kForceStep * 1.01);  // 1.01: as far beyond the bound;
                                                                 // round-off
  }
  while (last > 0) {
    const double share = Share(0);
    EXPECT_LE(last - share,
              StrainBlendController::kForceStep / StrainBlendController::kForceOverEnergy / kSlope +
                  1e-12);  // round-off
    last = share;
  }
}

TEST_F(StrainBlendControllerTest, FarBeyondTheBoundItHurriesWithinALimit) {
  Share(100 * kBound);
  const double last = Share(100 * kBound), next = Share(100 * kBound);
  EXPECT_NEAR((next - last) * kSlope * StrainBlendController::kForceOverEnergy,
              StrainBlendController::kMaxForceStep, 1e-12);  // round-off
}

TEST_F(StrainBlendControllerTest, WithoutContactItChangesAtOnce) {
  InTheEnd(2 * kBound);
  EXPECT_EQ(Share(2 * kBound, kNothingShed, false), 0);
}

TEST_F(StrainBlendControllerTest, ACeilingIsFollowedDownAndUpInSteps) {
  const QualityCeiling none{.halvings = 5, .finite = false, .refinement = false};
  InTheEnd(2 * kBound);
  StepQuality last = controller_.Next(kNothingShed, true, 2 * kBound, kSlope);
  EXPECT_EQ(last.newton_iterations, 4);
  EXPECT_EQ(last.refinement_weight, 1);
  EXPECT_TRUE(controller_.settled());
  for (int step = 0; step < 1000; ++step) {
    const StepQuality next = controller_.Next(none, true, 2 * kBound, kSlope);
    EXPECT_EQ(next.newton_iterations, 1) << "one is always made";
    EXPECT_LE(last.refinement_weight - next.refinement_weight,
              StrainBlendController::kRefinementStep);
    EXPECT_EQ(controller_.settled(), next.finite_strain_blend == 0 && next.refinement_weight == 0);
    last = next;
  }
  EXPECT_TRUE(controller_.settled());
  EXPECT_EQ(InTheEnd(2 * kBound), 1);
  EXPECT_EQ(controller_.Next(kNothingShed, true, 2 * kBound, kSlope).refinement_weight, 1);
}

TEST_F(StrainBlendControllerTest, ContinuesFromARecordedQuality) {
  controller_.ApplyRecorded(
      {.newton_iterations = 4, .finite_strain_blend = 0.5, .refinement_weight = 0.25});
  const StepQuality next = controller_.Next(kNothingShed, true, 2 * kBound, kSlope);
  EXPECT_GT(next.finite_strain_blend, 0.5);
  EXPECT_LT(next.finite_strain_blend, 0.6);
  EXPECT_EQ(next.refinement_weight, 0.25 + StrainBlendController::kRefinementStep);
}

TEST_F(FiniteStrainBlendTest, FiniteStrainIsAlwaysWhole) {
  EXPECT_EQ(Share(0, kNothingShed, false), 1);
  EXPECT_EQ(Share(0), 1);
  EXPECT_EQ(Share(10 * kBound), 1);
}

}  // namespace
}  // namespace hpdm
