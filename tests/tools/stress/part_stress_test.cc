#include <gtest/gtest.h>

#include <set>
#include <string>

#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

// A stretched duct whose sections tilt fails duct_pulled by 46 %, and duct_cut_tense does harm.
TEST(PartStress, EveryRowBearsWhatIsAsked) {
  const std::set<std::string> degraded = {"layer_overloaded", "free_torn_turned"};
  for (const StressCase& each : PartStress(true)) {
    const StressTrial trial = each.run(StressModel::kStrainSmall, each.parameter.asked);
    EXPECT_LE(trial.fate,
              degraded.contains(each.name) ? StressFate::kDegraded : StressFate::kSurvived)
        << each.name << ": " << trial.error.value_or(-1) << ' ' << trial.how;
    EXPECT_EQ(trial.harm, "") << each.name;
  }
}

TEST(PartStress, ADuctYankedFarWithinAStepFindsAnotherShape) {
  // By 13 of its lengths, against the same way in 40 steps.
  for (const StressCase& each : PartStress(true)) {
    if (each.name != "duct_yanked") continue;
    EXPECT_EQ(each.run(StressModel::kStrainSmall, each.parameter.utmost).fate, StressFate::kFailed);
  }
}

}  // namespace
}  // namespace hpdm
