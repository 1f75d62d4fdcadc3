// A scripted surgeon does an exercise to its end, and what is done wrong is found. The log, and so a
// replay and a report, judge as the session did.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/analysis/logged_session.h"
#include "scenes/loader/scene.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/scripted_hands.h"
#include "tools/replay/log_replay.h"
#include "tools/session/lockstep_session.h"
#include "tools/session/session.h"
#include "tools/session/session_recorder.h"

namespace hpdm {
namespace {

enum { kGrasper, kHook };

// The exercise on coarse lattices, with a strong hook and a small part of the bed to free.
Scene ShortExercise() {
  Scene scene = LoadScene(std::string(HPDM_SOURCE_DIR) + "/scenes/bed_dissection.toml");
  for (OrganOptions& organ : scene.organs) {
    organ.lattice.cells = {4, 4, 4};
    organ.lattice.local.functions = 0;
  }
  scene.instruments[kHook].geometry.power = 400;
  scene.exercise->steps[2].freed_area = 1e-4;
  return scene;
}

// Moves grasper and hook.
class Surgeon : public ScriptedHands {
 public:
  explicit Surgeon(LockstepSession* session)
      : ScriptedHands(session, Vector3d(0.008, -0.110, 0.032), 0) {}

  void TakeFundus() { Take(session_.model().organs()[1].rest().vertices.row(fundus_), 0.2); }
  // Burns from the fundus to the neck until the exercise's step is done.
  void Burn() {
    const std::size_t step = result().step_times.size();
    for (int i = 0; i < 600 && result().step_times.size() == step; ++i) {
      const Vector3d to_W = NextSample();
      if ((to_W - tips_W_[kHook]).norm() > 0.0012) {
        session_.Press(kHook, false);
        Move(kHook, to_W, 0.06);
      }
      session_.Press(kHook, true);
      Step();
    }
    session_.Press(kHook, false);
  }
  void BurnFor(double seconds) {
    session_.Press(kHook, true);
    Step(static_cast<int>(30 * seconds));
    session_.Press(kHook, false);
    Step(3);
  }
  // Presses the hook's tip into an organ near a place, along its shaft, m.
  void PressOn(std::size_t organ, const Vector3d& near_W, double depth) {
    const Points& rest = session_.model().organs()[organ].rest().vertices;
    Eigen::Index nearest = 0;
    (rest.rowwise() - near_W.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    const Vector3d point_W = rest.row(nearest);
    const Vector3d inward_W = (point_W - Kinematics(kHook).p_trocar_W()).normalized();
    Move(kHook, point_W - 0.02 * inward_W, 0.2);
    Move(kHook, point_W + (depth - 0.0015) * inward_W, 0.03);
  }
  void BackOff() { Move(kHook, tips_W_[kHook] + Vector3d(0.02, -0.03, 0.02), 0.1); }

 private:
  Vector3d NextSample() const {
    const AttachmentLink& link = session_.links()[0];
    const AttachmentJoint::Layer& layer = link.joint().layers()[0];
    Vector3d next_W = Vector3d::Zero();
    for (int i = 0; i < layer.bed.size(); ++i) {
      if (link.state().damage()[ToSize(i)] >= 1) continue;
      Vector3d middle_W = Vector3d::Zero();
      for (std::size_t side = 0; side < 2; ++side) {
        const auto o = ToSize(link.joint().members()[ToSize(layer.members[side])].organ);
        middle_W +=
            0.5 * layer.bed.surface_points[side][ToSize(i)].Position(
                      session_.organ(o).vertices, session_.model().organs()[o].rest().triangles);
      }
      if (middle_W.y() < next_W.y()) next_W = middle_W;
    }
    return next_W;
  }
};

class ExerciseSession : public testing::Test {
 protected:
  static LockstepSession MakeSession() {
    static const auto model = std::make_shared<const SessionModel>(ShortExercise());
    return SessionOf(model);
  }
  static LockstepSession SessionOf(std::shared_ptr<const SessionModel> model) {
    DeviceChoice command;
    command.type = DeviceChoice::Type::kCommand;
    return LockstepSession(std::move(model), {command, command});
  }

  // The log's steps give the same result, and its replay the same steps to the last bit.
  void ExpectLogAgrees(const std::string& log) const {
    const LoggedSession logged(log);
    ExerciseEvaluator judge(*ShortExercise().exercise);
    for (const LoggedStep& step : logged.steps()) judge.Add(step.sample);
    EXPECT_EQ(judge.result().score, surgeon_.result().score);
    EXPECT_EQ(judge.result().step_times, surgeon_.result().step_times);
    Session replayed(ShortExercise());
    const LogReplay replay = ReplayLog(logged, 0, &replayed);
    EXPECT_EQ(replay.ended_early, "");
    EXPECT_EQ(replay.steps_compared, replay.steps_logged);
    EXPECT_FALSE(replay.comparison.first_beyond());
  }

  LockstepSession session_ = MakeSession();
  Surgeon surgeon_{&session_};
};

using Names = std::vector<std::string>;

TEST_F(ExerciseSession, ASurgeonDoesItCleanlyAndTheLogAndItsReplayFindTheSame) {
  const ScratchFolder folder;
  SessionRecorder recorder(session_.model(), folder / "session", false);
  session_.RecordTo(&recorder);
  surgeon_.TakeFundus();
  surgeon_.Lift(0.012);
  surgeon_.Step(20);
  surgeon_.Burn();
  surgeon_.BackOff();
  surgeon_.Lift(-0.012);
  surgeon_.Jaws(kGrasper, 1);
  surgeon_.Step(30);
  EXPECT_EQ(recorder.Finish(), "");
  session_.RecordTo(nullptr);
  const ExerciseResult& result = surgeon_.result();
  EXPECT_EQ(surgeon_.Errors(), Names{});
  EXPECT_TRUE(result.passed);
  EXPECT_EQ(result.step_times.size(), 4u);
  EXPECT_EQ(result.score, 100) << "before the target time";
  const AttachmentOutcome& layer = session_.links()[0].outcomes()[0];
  EXPECT_GE(layer.freed_area, 1e-4);
  EXPECT_GT(layer.burnt_area, 0.9 * layer.freed_area);

  ExpectLogAgrees(folder / "session/session.lcmlog");
}

// He burns in the air and frees the bed, begins that step again, and does it well.
TEST_F(ExerciseSession, AStepThatBeginsAgainCountsAsDoneOnceAndTheReplayFindsTheSame) {
  const ScratchFolder folder;
  SessionRecorder recorder(session_.model(), folder / "session", false);
  session_.RecordTo(&recorder);
  session_.KeepSteps();
  surgeon_.TakeFundus();
  surgeon_.Lift(0.012);
  surgeon_.Step(20);
  ASSERT_EQ(surgeon_.done(), 2u);
  surgeon_.BurnFor(0.6);
  ASSERT_EQ(surgeon_.Errors(), Names{"hook energised away from tissue"});
  surgeon_.Burn();
  ASSERT_EQ(surgeon_.done(), 3u);
  const double freed = session_.links()[0].outcomes()[0].freed_area;
  surgeon_.BackOff();
  session_.Restart(2);
  surgeon_.Step(3);
  EXPECT_EQ(session_.links()[0].outcomes()[0].freed_area, 0);
  EXPECT_EQ(surgeon_.Errors(), Names{});
  EXPECT_EQ(surgeon_.done(), 2u);
  EXPECT_NE(session_.tools()[kGrasper].kind, static_cast<int>(ContactKind::kGrasp));

  surgeon_.Lift(-0.012);
  surgeon_.Jaws(kGrasper, 1);
  surgeon_.TakeFundus();
  surgeon_.Lift(0.012);
  surgeon_.Burn();
  surgeon_.BackOff();
  surgeon_.Lift(-0.012);
  surgeon_.Jaws(kGrasper, 1);
  surgeon_.Step(30);
  EXPECT_EQ(recorder.Finish(), "");
  session_.RecordTo(nullptr);
  const ExerciseResult& result = surgeon_.result();
  EXPECT_TRUE(result.passed);
  EXPECT_EQ(surgeon_.Errors(), Names{});
  ASSERT_EQ(result.restarts.size(), 1u);
  EXPECT_EQ(result.restarts[0].step, 2);
  EXPECT_EQ(result.restarts[0].errors, 1);
  EXPECT_NEAR(session_.links()[0].outcomes()[0].freed_area, freed, 0.2 * freed);

  ExpectLogAgrees(folder / "session/session.lcmlog");
}

TEST_F(ExerciseSession, AHookOnTheGallbladdersWallIsABurnAfterItsTime) {
  surgeon_.PressOn(1, {0.0063, -0.1127, 0.0182}, 0.003);
  surgeon_.BurnFor(0.2);
  EXPECT_EQ(surgeon_.Errors(), Names{}) << "a near miss";
  surgeon_.BurnFor(0.45);
  EXPECT_EQ(surgeon_.Errors(), Names{"burn of the gallbladder's wall"});
}

TEST_F(ExerciseSession, AHookOnTheLiverIsABurnAfterItsTime) {
  surgeon_.PressOn(0, {0.06, -0.07, 0.04}, 0.003);
  surgeon_.BurnFor(0.2);
  EXPECT_EQ(surgeon_.Errors(), Names{}) << "a near miss";
  surgeon_.BurnFor(0.45);
  EXPECT_EQ(surgeon_.Errors(), Names{"burn of the liver"});
}

TEST_F(ExerciseSession, AHookInTheAirIsAnErrorAfterItsTime) {
  surgeon_.Step(5);
  surgeon_.BurnFor(0.4);
  EXPECT_EQ(surgeon_.Errors(), Names{}) << "a near miss";
  surgeon_.BurnFor(0.6);
  EXPECT_EQ(surgeon_.Errors(), Names{"hook energised away from tissue"});
}

TEST_F(ExerciseSession, JawsThatOpenOnLiftedTissueDropIt) {
  surgeon_.TakeFundus();
  surgeon_.Lift(0.009);
  surgeon_.Step(10);
  surgeon_.Jaws(kGrasper, 1);
  surgeon_.Step(5);
  EXPECT_EQ(surgeon_.Errors(), Names{}) << "a near miss";
  surgeon_.Lift(-0.009);
  surgeon_.TakeFundus();
  surgeon_.Lift(0.016);
  surgeon_.Step(10);
  surgeon_.Jaws(kGrasper, 1);
  surgeon_.Step(5);
  EXPECT_EQ(surgeon_.Errors(), Names{"the gallbladder was dropped"});
}

TEST_F(ExerciseSession, AStrongPullTearsAWeakBed) {
  Scene scene = ShortExercise();
  scene.attachments[0].strength = 1000;
  scene.attachments[0].toughness = 1;
  LockstepSession session = SessionOf(std::make_shared<const SessionModel>(scene));
  Surgeon surgeon(&session);
  surgeon.TakeFundus();
  surgeon.Lift(0.002);
  surgeon.Step(10);
  EXPECT_EQ(surgeon.Errors(), Names{}) << "a near miss";
  surgeon.Lift(0.04);
  surgeon.Step(20);
  const Names errors = surgeon.Errors();
  EXPECT_NE(std::ranges::find(errors, "the bed was torn"), errors.end());
}

}  // namespace
}  // namespace hpdm
