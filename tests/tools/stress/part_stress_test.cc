#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

// The sections of a stretched duct tilt: duct_pulled is 46 % off.
TEST(PartStress, EveryRowBearsWhatIsAsked) {
  const std::set<std::string> degraded = {"duct_pulled", "layer_overloaded", "free_torn_turned"};
  for (const StressCase& each : PartStress(true)) {
    const StressTrial trial = each.run(StressModel::kStrainSmall, each.parameter.asked);
    EXPECT_LE(trial.fate,
              degraded.contains(each.name) ? StressFate::kDegraded : StressFate::kSurvived)
        << each.name << ": " << trial.error.value_or(-1) << ' ' << trial.how;
    EXPECT_EQ(trial.harm, "") << each.name;
  }
}

TEST(PartStress, ADuctYankedFarWithinAStepFindsAnotherShape) {
  // One step moves it by 13 of its lengths; the reference takes 40 steps for the same way.
  for (const StressCase& each : PartStress(true)) {
    if (each.name != "duct_yanked") continue;
    EXPECT_EQ(each.run(StressModel::kStrainSmall, each.parameter.utmost).fate, StressFate::kFailed);
  }
}

}  // namespace
}  // namespace hpdm
