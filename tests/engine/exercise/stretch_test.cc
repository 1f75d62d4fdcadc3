// Judgement of stretched ducts on made steps.

#include <gtest/gtest.h>

#include <vector>

#include "engine/exercise/exercise_evaluator.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPullPeriod = 33'333'333;
enum { kPulledDuct, kPulledArtery };
enum { kLeftHand, kRightHand };  // hands

class Stretches : public testing::Test {
 protected:
  // The artery alone is judged, or both.
  explicit Stretches(std::vector<int> judged = {kPulledArtery})
      : judge_(Exercise(std::move(judged))) {
    sample_.tool_count = 2;
    sample_.duct_count = 2;
    for (const int hand : {kLeftHand, kRightHand}) {
      SolvedContact& contact = sample_.contacts[ToSize(hand)];
      contact.organ = hand;
      contact.kind = ContactKind::kGrasp;
      contact.contact_W = Vector3d(hand, 0, 0);
      contact.force_on_tissue_W = Vector3d(0, 1 + hand, 0);
    }
  }

  static ExerciseOptions Exercise(std::vector<int> judged) {
    ExerciseOptions exercise;
    exercise.time_limit = 100;
    exercise.target_time = 20;
    exercise.steps.push_back({.name = "wait", .force = 100, .time = 90});
    exercise.ducts = {{.name = "duct"}, {.name = "artery"}};
    exercise.errors.push_back({.kind = ExerciseErrorKind::kStretch,
                               .name = "pulled",
                               .limit = 1.5,
                               .ducts = std::move(judged)});
    return exercise;
  }

  // Runs a step with so many times the lengths at rest. Returns the number of errors.
  std::size_t Step(double duct, double artery) {
    sample_.step.time_ns += kPullPeriod;
    sample_.step.device_time_ns = sample_.step.time_ns;
    sample_.ducts[kPulledDuct].length = duct * 0.03;
    sample_.ducts[kPulledArtery].length = artery * 0.02;
    sample_.ducts[kPulledArtery].tension = 0.7;
    judge_.Add(sample_);
    return judge_.result().errors.size();
  }

  StepSample sample_;
  ExerciseEvaluator judge_;
};

TEST_F(Stretches, AreAnErrorAboveTheLimitOfTheHandThatExertsMost) {
  EXPECT_EQ(Step(1, 1), 0u);
  EXPECT_EQ(Step(2, 1.499), 0u) << "the other duct is not judged";
  EXPECT_EQ(Step(2, 1.501), 1u);
  const ExerciseError& error = judge_.result().errors[0];
  EXPECT_EQ(error.hand, kRightHand);
  EXPECT_EQ(error.organ, 1);
  EXPECT_EQ(error.place_W, Vector3d(1, 0, 0));
  EXPECT_EQ(error.force, 0.7) << "the artery's tension";
  EXPECT_EQ(error.duct, kPulledArtery);
}

TEST_F(Stretches, CountAgainOnceTheDuctWasBelowTheLimit) {
  EXPECT_EQ(Step(1, 1), 0u);
  EXPECT_EQ(Step(1, 1.6), 1u);
  EXPECT_EQ(Step(1, 1.45), 1u);
  EXPECT_EQ(Step(1, 1.6), 1u) << "1.45 is above 95 % of the limit";
  EXPECT_EQ(Step(1, 1.42), 1u);
  EXPECT_EQ(Step(1, 1.6), 2u);
}

class StretchesOfAllDucts : public Stretches {
 protected:
  StretchesOfAllDucts() : Stretches(std::vector<int>{}) {}
};

TEST_F(StretchesOfAllDucts, CountForEachDuct) {
  EXPECT_EQ(Step(1, 1), 0u);
  EXPECT_EQ(Step(1.6, 1), 1u);
  EXPECT_EQ(Step(1.6, 1.6), 2u);
  EXPECT_EQ(Step(1, 1.6), 2u);
  EXPECT_EQ(Step(1.6, 1.6), 3u);
}

}  // namespace
}  // namespace hpdm
