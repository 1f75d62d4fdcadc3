#include <gtest/gtest.h>

#include <algorithm>

#include "tools/stress/stress_cases.h"

namespace hpdm {
namespace {

StressCase Case(const std::string& name) {
  const std::vector<StressCase> cases = ContactStress(true);
  return *std::find_if(cases.begin(), cases.end(),
                       [&](const StressCase& each) { return each.name == name; });
}

TEST(ContactStress, ContactsThatCoincideAreOne) {
  const StressCase coincident = Case("coincident_contacts");
  for (const StressModel model : {StressModel::kStrainSmall, StressModel::kContinuum}) {
    for (const double distance : {1e-6, 1e-12, 1e-18}) {
      const StressTrial trial = coincident.run(model, distance);
      EXPECT_EQ(trial.harm, "");
      // The first contact already meets the second one's target, except for round-off: the pad of
      // 1e-9.
      EXPECT_LT(*trial.error, 1e-6) << Name(model) << " at " << distance << " m";
    }
  }
}

TEST(ContactStress, MoreContactsThanControlPointsAreNearlyALeastSquaresFit) {
  const StressCase many = Case("many_contacts");
  for (const StressModel model : {StressModel::kStrainSmall, StressModel::kStrainFinite}) {
    const StressTrial trial = many.run(model, 32);
    EXPECT_EQ(trial.harm, "");
    EXPECT_LT(*trial.error, 0.05) << "the slip that their forces leave, and no support";
  }
}

}  // namespace
}  // namespace hpdm
