#include "tools/haptics/tissue_tables.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/prony.h"
#include "tools/haptics/tissue_law.h"

namespace hpdm {
namespace {

const PronySeries kThreeTerms = Prony({{0.3, 0.02}, {0.2, 0.5}, {0.25, 5}});
constexpr double kPeriod = 0.001;  // s

TEST(RelaxedForce, OfAStepAndARampAreTheClosedForms) {
  constexpr int kTicks = 2000, kRamp = 400;
  std::vector<double> step(kTicks, 1.0), ramp;
  step[0] = 0;
  for (int i = 0; i < kTicks; ++i) ramp.push_back(std::min(1.0, 1.0 * i / kRamp));
  const std::vector<double> of_step = RelaxedForce(kThreeTerms, step, kPeriod);
  const std::vector<double> of_ramp = RelaxedForce(kThreeTerms, ramp, kPeriod);
  for (int i = 1; i < kTicks; ++i) {
    double relaxed = 0, held = ramp[static_cast<std::size_t>(i)];
    const double t = kPeriod * i, until = kPeriod * std::min(i, kRamp);
    for (int k = 0; k < 3; ++k) {
      const auto& [share, time] = kThreeTerms.terms[static_cast<std::size_t>(k)];
      relaxed += share * (1 - std::exp(-(t - kPeriod / 2) / time));
      held += share / 0.25 * time / (kPeriod * kRamp) *
              (std::exp(-(t - until) / time) - std::exp(-t / time));
    }
    EXPECT_NEAR(of_step[static_cast<std::size_t>(i)], (1 - relaxed) / 0.25, 2e-3) << i;
    EXPECT_NEAR(of_ramp[static_cast<std::size_t>(i)], held, 1e-5) << i;
  }
}

TEST(FundamentalOf, FindsASineInADrift) {
  std::vector<double> signal;
  for (int i = 0; i < 3000; ++i) {
    const double t = kPeriod * i;
    signal.push_back(5 + t - 0.2 * t * t + 0.3 * std::sin(2 * std::numbers::pi * 1.5 * t + 0.4));
  }
  const Fundamental found = FundamentalOf(signal, 2000, 1.5, kPeriod);
  EXPECT_NEAR(found.amplitude, 0.3, 1e-9);
  EXPECT_NEAR(found.phase, 0.4, 1e-9);
}

class TissuePressTest : public testing::TestWithParam<double> {
 protected:
  TissuePressTest() {
    press_ = {.block = {.squares = 8},
              .prony = kThreeTerms,
              .tip_radius = GetParam(),
              .friction = 0.5,
              .place_W = Vector3d(0.0113, 0.0071, 0)};
  }
  TissuePress press_;
};
INSTANTIATE_TEST_SUITE_P(Tips, TissuePressTest, testing::Values(0.0025, 0.015));

// The law in step and tick, and a judgement that misses another law.
TEST_P(TissuePressTest, FollowsItsOwnLawAndNoOther) {
  const RelaxedPress relaxed(press_, 0.005);
  const HoldError own = MeasureHold(press_, relaxed, kThreeTerms);
  EXPECT_LT(own.step, 0.002);
  EXPECT_LT(own.ramp, 0.002);
  EXPECT_LT(own.hold, 0.002);
  PronySeries slower = kThreeTerms;
  slower.terms[1].time *= 1.2;
  const HoldError other = MeasureHold(press_, relaxed, slower);
  EXPECT_GT(other.step, kTissueForceError);
  EXPECT_GT(other.hold, kTissueForceError);
}

TEST_P(TissuePressTest, HasTheLawsModulusAndPhase) {
  const RelaxedPress relaxed(press_, 0.005);
  const SineError own = MeasureSine(press_, relaxed, kThreeTerms, 10);
  EXPECT_NEAR(own.ratio, 1, 0.003);
  EXPECT_NEAR(own.phase, 0, 0.3);
  PronySeries less = kThreeTerms;
  less.terms[0].share = 0.1;
  const SineError other = MeasureSine(press_, relaxed, less, 10);
  EXPECT_GT(std::abs(other.ratio - 1), kTissueForceError);
  EXPECT_GT(std::abs(other.phase), kTissuePhaseError);
}

}  // namespace
}  // namespace hpdm
