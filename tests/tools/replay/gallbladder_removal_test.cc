// A scripted surgeon removes the gallbladder of scenes/gallbladder_removal.toml on coarse lattices. What is
// done wrong is found, and a near miss beside it is not. The log and its replay judge as the session did.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/analysis/logged_session.h"
#include "scenes/loader/scene.h"
#include "tests/support/removal_surgeon.h"
#include "tests/support/scratch_folder.h"
#include "tools/replay/log_replay.h"
#include "tools/session/lockstep_session.h"
#include "tools/session/session.h"
#include "tools/session/session_recorder.h"

namespace hpdm {
namespace {

using ErrorNames = std::vector<std::string>;
constexpr double kDegreeOfClip = std::numbers::pi / 180;
const char* const kBadClip = "clip oblique, loose, or too near to a clip or the bile duct";

// The scene on coarse lattices, with a strong hook.
Scene CoarseRemoval() {
  Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/gallbladder_removal.toml");
  for (OrganOptions& organ : scene.organs) {
    organ.lattice.cells = {4, organ.name == "liver" ? 4 : 7, 4};
    organ.lattice.local.functions = 0;
  }
  scene.instruments[RemovalSurgeon::kRight].geometry.power = 400;
  return scene;
}

class GallbladderRemoval : public testing::Test {
 protected:
  static LockstepSession MakeSession() {
    static const auto model = std::make_shared<const SessionModel>(CoarseRemoval());
    DeviceChoice command;
    command.type = DeviceChoice::Type::kCommand;
    return LockstepSession(model, {command, command});
  }
  // Errors that clipping and cutting made.
  ErrorNames ClipErrors() const {
    ErrorNames names;
    for (const ExerciseError& error : surgeon_.result().errors) {
      const ExerciseErrorOptions& rule = session_.exercise()->options().errors[ToSize(error.rule)];
      const bool early = rule.kind == ExerciseErrorKind::kEarlyClip;
      if (rule.kind >= ExerciseErrorKind::kBadClip && !early) names.push_back(rule.name);
    }
    return names;
  }

  LockstepSession session_ = MakeSession();
  RemovalSurgeon surgeon_{&session_};
};

TEST_F(GallbladderRemoval, ASurgeonDoesItCleanly) {
  EXPECT_EQ(surgeon_.Operate(), 11u);
  EXPECT_EQ(surgeon_.Errors(), ErrorNames{});
  EXPECT_TRUE(surgeon_.result().passed);
  EXPECT_EQ(surgeon_.result().score, 100) << "before the target time";
}

// Without its layers the gallbladder would yield by metres for a newton: only a weak spring would hold it.
TEST_F(GallbladderRemoval, JawsThatCloseOnAPressKeepItsForce) {
  const LockstepSession before = session_;
  const auto left = [this] { return session_.tools()[RemovalSurgeon::kLeft]; };
  for (const Vector3d& place_W : {Vector3d(0.0225, -0.1, 0.0152), Vector3d(0.02, -0.095, 0.02)}) {
    for (const Vector3d& from_W : {Vector3d(-0.03, -0.12, 0.04), Vector3d(0.01, -0.14, 0.02)}) {
      session_ = before;
      RemovalSurgeon surgeon(&session_);
      surgeon.Move(RemovalSurgeon::kLeft, from_W, 0.2);
      surgeon.Move(RemovalSurgeon::kLeft, place_W, 0.05);
      surgeon.Step(30);
      const Vector3d pressed(left().force.data());
      EXPECT_GT(pressed.norm(), 0.1);
      surgeon.Jaws(RemovalSurgeon::kLeft, 0);
      EXPECT_EQ(left().kind, static_cast<int>(ContactKind::kGrasp));
      const Vector3d held(left().force.data());
      EXPECT_NEAR(held.norm(), pressed.norm(), 0.05 * pressed.norm()) << place_W << from_W;
    }
  }
}

TEST_F(GallbladderRemoval, TheLogAndItsReplayJudgeClipsAndCutsAsTheSessionDid) {
  const ScratchFolder folder;
  SessionRecorder recorder(session_.model(), folder / "session", false);
  session_.RecordTo(&recorder);
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.012);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.018, 0, -0.003);
  surgeon_.Exchange(RemovalSurgeon::kScissors);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.016);
  EXPECT_EQ(recorder.Finish(), "");
  session_.RecordTo(nullptr);

  const LoggedSession logged(folder / "session/session.lcmlog");
  ExerciseEvaluator judge(*CoarseRemoval().exercise);
  std::vector<DuctActionKind> actions;
  for (const LoggedStep& step : logged.steps()) {
    judge.Add(step.sample);
    const DuctAction& action = step.sample.duct_actions[RemovalSurgeon::kRight];
    if (action.kind != DuctActionKind::kNone) actions.push_back(action.kind);
  }
  EXPECT_EQ(actions, (std::vector<DuctActionKind>{DuctActionKind::kClip, DuctActionKind::kLostClip,
                                                  DuctActionKind::kCut}));
  ASSERT_EQ(judge.result().errors.size(), surgeon_.result().errors.size());
  EXPECT_EQ(judge.result().errors.size(), 4u) << "early clip, lost clip, early cut, cut outside";
  for (std::size_t e = 0; e < judge.result().errors.size(); ++e) {
    EXPECT_EQ(judge.result().errors[e].rule, surgeon_.result().errors[e].rule);
    EXPECT_EQ(judge.result().errors[e].time, surgeon_.result().errors[e].time);
    EXPECT_EQ(judge.result().errors[e].place_W, surgeon_.result().errors[e].place_W);
  }
  EXPECT_EQ(judge.result().score, surgeon_.result().score);
  Session replayed(CoarseRemoval());
  const LogReplay replay = ReplayLog(logged, 0, &replayed);
  EXPECT_EQ(replay.ended_early, "");
  EXPECT_EQ(replay.steps_compared, replay.steps_logged);
  EXPECT_FALSE(replay.comparison.first_beyond()) << "bit for bit, clips and cuts included";
}

TEST_F(GallbladderRemoval, AClipTurnedTooFarIsBad) {
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  // The way of the shaft tilts the jaws, too: cos(angle) = cos(tilt) cos(turn).
  const auto close = [&](double arc, double angle) {
    const double tilt = surgeon_.BestAngle(RemovalSurgeon::kCysticDuct, arc);
    surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, arc, std::acos(std::cos(angle) / std::cos(tilt)));
  };
  close(0.012, 19 * kDegreeOfClip);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "a near miss";
  close(0.020, 21 * kDegreeOfClip);
  EXPECT_EQ(ClipErrors(), ErrorNames{kBadClip});
}

TEST_F(GallbladderRemoval, AClipTooNearToAnotherIsBad) {
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.010);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.0131);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "2.1 mm between them, a near miss";
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.0160);
  EXPECT_EQ(ClipErrors(), ErrorNames{kBadClip}) << "1.9 mm";
}

TEST_F(GallbladderRemoval, AClipTooNearToTheBileDuctIsBad) {
  const double length = surgeon_.RodOf(RemovalSurgeon::kCysticDuct).rest_length();
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, length - 0.0037);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "a near miss";
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.0017);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "the gallbladder goes";
  surgeon_.CloseOn(RemovalSurgeon::kCysticArtery, 0.0033);
  EXPECT_EQ(ClipErrors(), ErrorNames{kBadClip}) << "at the hepatic artery";
}

TEST_F(GallbladderRemoval, AClipThatDoesNotReachAcrossIsBad) {
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.012, 0, 0.0024);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "a near miss";
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.018, 0, 0.0018);
  EXPECT_EQ(ClipErrors(), ErrorNames{kBadClip});
}

TEST_F(GallbladderRemoval, AnApplierThatClosesOnNothingLosesItsClip) {
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.012, 0, 0.0075);
  EXPECT_EQ(ClipErrors(), ErrorNames{}) << "the duct is at the end of the jaws, a near miss";
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, 0.018, 0, -0.003);
  EXPECT_EQ(ClipErrors(), ErrorNames{"clip lost"});
}

TEST_F(GallbladderRemoval, CutsBeforeTheViewAndOutsideTheClipsAreErrors) {
  surgeon_.Exchange(RemovalSurgeon::kClipApplier);
  for (const double arc : surgeon_.ClipsOf(RemovalSurgeon::kCysticDuct)) {
    surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, arc);
  }
  EXPECT_EQ(ClipErrors(), ErrorNames{});
  surgeon_.Exchange(RemovalSurgeon::kScissors);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, surgeon_.CutOf(RemovalSurgeon::kCysticDuct));
  EXPECT_EQ(ClipErrors(), ErrorNames{"cut before the critical view"}) << "but between the clips";
  const auto clips = surgeon_.ClipsOf(RemovalSurgeon::kCysticDuct);
  surgeon_.CloseOn(RemovalSurgeon::kCysticDuct, (clips[0] + clips[1]) / 2);
  EXPECT_EQ(ClipErrors(), (ErrorNames{"cut before the critical view",
                                      "cut before the critical view", "cut outside the clips"}));
}

}  // namespace
}  // namespace hpdm
