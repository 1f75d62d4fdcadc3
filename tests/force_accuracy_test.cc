// The felt force between two deformation steps, against the whole model solved at every tick.
#include "tools/force_accuracy.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "engine/error.h"
#include "tools/accuracy_cases.h"

namespace hpdm {
namespace {

constexpr double kRate = 1000, kComb = 30;

Scene TwoHands() { return LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/two_hands.toml"); }

Scene CaseScene(const std::string& name) {
  for (const AccuracyCase& each : AccuracyCases(TwoHands(), true)) {
    if (each.name == name) return each.scene;
  }
  ADD_FAILURE() << name;
  return {};
}

// Along the normal of the tissue, so that only the tip touches.
Scene Upright(Scene scene) {
  for (InstrumentOptions& instrument : scene.instruments) {
    instrument.p_trocar_W = *instrument.hand.target + Vector3d(0, -0.02, 0.15);
  }
  return scene;
}

ForceSignal Signal(int ticks, const std::function<double(double)>& force) {
  ForceSignal signal;
  for (int t = 0; t < ticks; ++t) signal.emplace_back(0, 0, force(t / kRate));
  return signal;
}

TEST(ForceSignal, ErrorIsOverThePeakAndInContactOnly) {
  ForceSignal reference(100, Vector3d::Zero()), force(100, Vector3d::Zero());
  for (int t = 40; t < 60; ++t) {
    reference[t] = {0, 0, 2};
    force[t] = {0, 0.1, 2};
  }
  EXPECT_NEAR(ContactError(force, reference), 0.05, 1e-12);  // arithmetic
  EXPECT_EQ(ContactError(reference, reference), 0);
  EXPECT_NEAR(LargestStep(reference), 2, 1e-12);
}

// 1 N with a hand's tremor of 10 % and a comb of 2 % in the fundamental and 1 % in the third.
TEST(ForceSignal, CombIsWhatTheReferenceDoesNotHaveAtTheHarmonics) {
  const auto hand = [](double t) { return 1 + 0.1 * std::sin(2 * std::numbers::pi * 9.3 * t); };
  const ForceSignal reference = Signal(1700, hand);
  const ForceSignal force = Signal(1700, [&](double t) {
    return hand(t) + 0.02 * std::sqrt(2) * std::sin(2 * std::numbers::pi * kComb * t + 1) +
           0.01 * std::sqrt(2) * std::cos(2 * std::numbers::pi * 3 * kComb * t);
  });
  // The sinusoids' root mean squares, over that of the whole: the window's side lobes leave 1e-4.
  const double whole = std::sqrt(1 + 0.5 * 0.01 + 5e-4);
  EXPECT_NEAR(Comb(force, reference, kRate, kComb), std::hypot(0.02, 0.01) / whole, 2e-4);
  EXPECT_LT(Comb(reference, reference, kRate, kComb), 1e-12);
}

TEST(ForceSignal, CombOfAShortContactIsUnknown) {
  ForceSignal force(1000, Vector3d::Zero());
  for (int t = 100; t < 200; ++t) force[t] = {0, 0, 1};  // three periods
  EXPECT_TRUE(std::isnan(Comb(force, force, kRate, kComb)));
}

TEST(AccuracyCases, NeedAGrasper) {
  Scene scene = TwoHands();
  scene.instruments.pop_back();
  EXPECT_THROW(AccuracyCases(scene, true), InputError);
}

struct Claim {
  const char* name;
  double error;  // at most, of the peak
};

class FeltForceOf : public testing::TestWithParam<Claim> {};

TEST_P(FeltForceOf, AHandIsTheWholeModels) {
  const ForceAccuracy accuracy = MeasureForceAccuracy(Upright(CaseScene(GetParam().name)), 1.6);
  for (const ForceFigures& figures : accuracy.figures) {
    std::printf("%s, %s: %.2f %% of %.3f N, comb %.2f %%, step %.4f N (%.4f), paper %.1f %%\n",
                GetParam().name, figures.instrument.c_str(), 100 * figures.error, figures.peak,
                100 * figures.comb, figures.largest_step, figures.reference_largest_step,
                100 * figures.paper_fitted_error);
    EXPECT_GT(figures.peak, 0.1);
    EXPECT_GT(figures.contact_ticks, 100);
    EXPECT_EQ(figures.shaft_ticks, 0);
    EXPECT_LT(figures.error, GetParam().error);
    // Where no time has passed since the step the tick gives the step's own force, to what the
    // relaxation leaves of it.
    EXPECT_LT(figures.largest_tick_error, 1e-6);
    // At most one percent of the force may have the rhythm of the steps.
    EXPECT_FALSE(figures.comb > 0.01);  // unknown for the short contacts of a tap
    // A linear spring, with the stiffness that fits this very course best, is far worse.
    EXPECT_GT(figures.paper_fitted_error, 2 * figures.error);
  }
}

INSTANTIATE_TEST_SUITE_P(Hands, FeltForceOf,
                         testing::Values(Claim{"press", 0.05}, Claim{"slide", 0.05},
                                         Claim{"tap", 0.05}, Claim{"grasp_pull", 0.02},
                                         Claim{"press_grasp_pull", 0.05},
                                         Claim{"slide_press", 0.05}),
                         [](const auto& claim) { return claim.param.name; });

}  // namespace
}  // namespace hpdm
