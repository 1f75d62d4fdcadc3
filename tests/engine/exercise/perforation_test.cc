// Judgement of perforations on made steps.

#include <gtest/gtest.h>

#include "engine/exercise/exercise_evaluator.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kBurnPeriod = 33'333'333;
enum { kLiverWall, kGallbladderWall };
enum { kLeftGrasper, kRightHook };  // hands

class Perforations : public testing::Test {
 protected:
  static ExerciseOptions Exercise(int organ) {
    ExerciseOptions exercise;
    exercise.time_limit = 100;
    exercise.target_time = 20;
    exercise.steps.push_back({.name = "wait", .force = 100, .time = 90});
    exercise.hooks.push_back({kRightHook, 0});
    exercise.errors.push_back(
        {.kind = ExerciseErrorKind::kPerforation, .name = "hole", .organ = organ, .points = 7});
    return exercise;
  }

  // Runs a step in which each hand presses an organ; -1: none.
  void Step(ExerciseEvaluator* judge, int grasper, int hook, bool pedal) {
    sample_.tool_count = 2;
    sample_.step.time_ns += kBurnPeriod;
    sample_.step.device_time_ns = sample_.step.time_ns;
    ++sample_.step.number;
    const auto press = [this](int hand, int organ, double x) {
      SolvedContact& contact = sample_.contacts[static_cast<std::size_t>(hand)];
      contact = {};
      contact.organ = organ;
      contact.kind = organ < 0 ? ContactKind::kNone : ContactKind::kPress;
      contact.contact_W = Vector3d(x, 0, 0);
      contact.force_on_tissue_W = Vector3d(0, x, 0);
    };
    press(kLeftGrasper, grasper, 0.1);
    press(kRightHook, hook, 0.2);
    sample_.tools[kRightHook].pedal = pedal;
    judge->Add(sample_);
  }

  StepSample sample_;
};

// A hook burns on the gallbladder, which is no error until its lumen leaks.
TEST_F(Perforations, AreAnErrorOnceAtTheFirstStepAfterTheEvent) {
  ExerciseEvaluator judge(Exercise(kGallbladderWall));
  for (int step = 0; step < 60; ++step) Step(&judge, kGallbladderWall, kGallbladderWall, true);
  EXPECT_TRUE(judge.result().errors.empty());
  judge.AddPerforation(61 * kBurnPeriod, kGallbladderWall);
  Step(&judge, kGallbladderWall, kGallbladderWall, true);
  EXPECT_TRUE(judge.result().errors.empty()) << "the event is not before this step";
  for (int step = 0; step < 9; ++step) Step(&judge, kGallbladderWall, kGallbladderWall, true);
  ASSERT_EQ(judge.result().errors.size(), 1u);
  const ExerciseError& error = judge.result().errors[0];
  EXPECT_NEAR(error.time, 61 * ToSeconds(kBurnPeriod), 1e-9);
  EXPECT_EQ(error.hand, kRightHook);
  EXPECT_EQ(error.organ, kGallbladderWall);
  EXPECT_EQ(error.place_W.x(), 0.2);
  EXPECT_EQ(error.force, 0.2);
}

TEST_F(Perforations, OfAnotherOrganAreNone) {
  ExerciseEvaluator judge(Exercise(kGallbladderWall)), any(Exercise(-1));
  for (ExerciseEvaluator* each : {&judge, &any}) {
    sample_ = {};
    Step(each, kGallbladderWall, kGallbladderWall, true);
    each->AddPerforation(kBurnPeriod, kLiverWall);
    Step(each, kGallbladderWall, kGallbladderWall, true);
  }
  EXPECT_EQ(judge.result().errors.size(), 0u);
  ASSERT_EQ(any.result().errors.size(), 1u);
  EXPECT_EQ(any.result().errors[0].hand, -1) << "no hand is on the liver";
}

// Scissors cut without a pedal, and the hook burns another organ.
TEST_F(Perforations, BelongToTheHandThatWasOnTheOrgan) {
  ExerciseEvaluator judge(Exercise(kGallbladderWall));
  Step(&judge, kGallbladderWall, kLiverWall, true);
  judge.AddPerforation(kBurnPeriod, kGallbladderWall);
  Step(&judge, -1, kLiverWall, true);
  ASSERT_EQ(judge.result().errors.size(), 1u);
  EXPECT_EQ(judge.result().errors[0].hand, kLeftGrasper);
}

}  // namespace
}  // namespace hpdm
