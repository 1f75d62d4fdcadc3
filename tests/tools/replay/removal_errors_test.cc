// The exercise finds each scripted error of a gallbladder's removal, and flags no near miss
// (tests/support/removal_errors.h and further_removal_errors.h). The scripts run sessions on coarse lattices, here of artery_in_front with
// seed 0, since `ctest` has little time. build/tests/try_errors runs other anatomies and seeds;
// tools/report/README.md has its results. Errors that no script makes reliably (tears, inverted tissue, a bleeding
// that lasts) have their near misses in tests/engine/exercise.

#include "tests/support/removal_errors.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/support/anatomy_removal.h"
#include "tests/support/further_removal_errors.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

TEST(ScriptedErrors, AreFoundAndNearMissesAreNot) {
  const ScratchFolder folder;
  const auto model = std::make_shared<const SessionModel>(
      RemovalOf(AnatomyVariant::kArteryInFront, 0, folder.path().string()));
  RemovalErrorTrials trials(model);
  ASSERT_EQ(trials.done(), 5u) << "up to the critical view";
  EXPECT_EQ(trials.Errors(), std::vector<std::string>{});
  std::vector<RemovalError> errors = RemovalErrors();
  EXPECT_EQ(errors.size(), 21u);
  for (const RemovalError& error : FurtherRemovalErrors()) errors.push_back(error);
  for (const RemovalError& error : errors) {
    const ErrorTrial trial = trials.Try(error);
    EXPECT_TRUE(trial.done) << error.name;
    EXPECT_TRUE(trial.found) << error.name;
    EXPECT_FALSE(trial.false_alarm) << error.name;
    EXPECT_EQ(trial.unexpected, std::vector<std::string>{}) << error.name;
  }
}

// In this anatomy the closed scissors come out beside the neck, which they touch: they must not keep hold of
// it. They pulled the duct to twice its length.
TEST(ScriptedErrors, DoNotFollowFromScissorsThatLeave) {
  const ScratchFolder folder;
  const auto model = std::make_shared<const SessionModel>(
      RemovalOf(AnatomyVariant::kShortDuct, 1, folder.path().string()));
  RemovalErrorTrials trials(model);
  ASSERT_EQ(trials.done(), 5u) << "up to the critical view";
  for (const RemovalError& error : RemovalErrors()) {
    if (error.name != "a cut after and before the critical view") continue;
    const ErrorTrial trial = trials.Try(error);
    EXPECT_TRUE(trial.done && trial.found);
    EXPECT_FALSE(trial.false_alarm);
    EXPECT_EQ(trial.unexpected, std::vector<std::string>{});
  }
}

}  // namespace
}  // namespace hpdm
