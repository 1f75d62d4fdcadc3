// Judgement of clips and cuts on made steps. Each rule has an error and a near miss beside it.

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/exercise/exercise_evaluator.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kStepPeriod = 33'333'333;
constexpr double kLength = 0.03;  // m
constexpr double kDegree = std::numbers::pi / 180;
enum { kDuct, kArtery, kBranch };
enum { kLiverOrgan, kBileDuct };

// The duct goes from the organ that is taken out into the body, the artery comes from the body; the
// branch has no end at that organ.
ExerciseOptions DuctExercise(const ExerciseErrorOptions& error) {
  ExerciseOptions exercise;
  exercise.time_limit = 100;
  exercise.target_time = 20;
  exercise.ducts = {{"duct", 0}, {"artery", 1}, {"branch", -1}};
  exercise.steps.push_back({.name = "clip", .clips = {kDuct}});
  exercise.steps.push_back({.name = "cut", .cuts = {kDuct}});
  exercise.errors.push_back(error);
  return exercise;
}

DuctAction Clip(double arc, int duct = kDuct) {
  DuctAction clip;
  clip.kind = DuctActionKind::kClip;
  clip.duct = duct;
  clip.arc = arc;
  clip.length = kLength;
  clip.coverage = 1;
  clip.place_W = Vector3d(0, 0, arc);
  return clip;
}
DuctAction Tilted(double degrees, double arc = 0.01) {
  DuctAction clip = Clip(arc);
  clip.angle = kDegree * degrees;
  return clip;
}
DuctAction Covering(double share) {
  DuctAction clip = Clip(0.01);
  clip.coverage = share;
  return clip;
}
DuctAction Cut(double arc, int duct = kDuct) {
  DuctAction cut = Clip(arc, duct);
  cut.kind = DuctActionKind::kCut;
  return cut;
}
DuctAction Lost() {
  DuctAction lost;
  lost.kind = DuctActionKind::kLostClip;
  return lost;
}
// A clip or a cut while the applier's tip presses an organ.
struct Act {
  DuctAction action;
  int pressed = -1;
};

/// A session in which the second hand clips and cuts.
class DuctCourse {
 public:
  explicit DuctCourse(ExerciseOptions exercise) : evaluator_(std::move(exercise)) {
    sample_.tool_count = 2;
    Run({});
  }
  void Run(const Act& act) {
    sample_.duct_actions[1] = act.action;
    SolvedContact& contact = sample_.contacts[1];
    contact = {};
    contact.organ = act.pressed;
    if (act.pressed >= 0) {
      contact.kind = ContactKind::kPress;
      contact.force_on_tissue_W = Vector3d(0.5, 0, 0);
    }
    for (int step = 0; step < 2; ++step) {
      sample_.step.time_ns += kStepPeriod;
      sample_.step.device_time_ns = sample_.step.time_ns;
      evaluator_.Add(sample_);
      sample_.duct_actions[1] = {};
    }
  }
  const ExerciseResult& result() const { return evaluator_.result(); }
  const ExerciseEvaluator& evaluator() const { return evaluator_; }
  std::size_t errors() const { return result().errors.size(); }
  std::size_t done() const { return result().step_times.size(); }

 private:
  StepSample sample_;
  ExerciseEvaluator evaluator_;
};

struct DuctCase {
  std::string name;
  ExerciseErrorOptions error;
  std::vector<Act> before;
  Act wrong, near_miss;
};
void PrintTo(const DuctCase& c, std::ostream* out) { *out << c.name; }
class DuctErrors : public testing::TestWithParam<DuctCase> {};

const ExerciseErrorOptions kBadClip = {ExerciseErrorKind::kBadClip, "", 20 * kDegree};
const ExerciseErrorOptions kBadCut = {ExerciseErrorKind::kBadCut};
const ExerciseErrorOptions kEarlyCut = {.kind = ExerciseErrorKind::kEarlyCut, .before = 0};
const ExerciseErrorOptions kEarlyClip = {
    .kind = ExerciseErrorKind::kEarlyClip, .ducts = {kArtery}, .before = 0};
const ExerciseErrorOptions kWrongDuct = {.kind = ExerciseErrorKind::kWrongClip,
                                         .ducts = {kDuct, kArtery}};
const ExerciseErrorOptions kWrongOrgan = {.kind = ExerciseErrorKind::kWrongClip,
                                          .organ = kBileDuct};
const ExerciseErrorOptions kLostClip = {ExerciseErrorKind::kLostClip};
const std::vector<Act> kThreeClips = {{Clip(0.01)}, {Clip(0.015)}, {Clip(0.02)}};
const std::vector<Act> kArteryClips = {
    {Clip(0.01, kArtery)}, {Clip(0.015, kArtery)}, {Clip(0.02, kArtery)}};

// A clip is 1 mm wide. It leaves a gap of 2 mm, and 3 mm to the end in the body.
const DuctCase kDuctCases[] = {
    {"angle", kBadClip, {}, {Tilted(21)}, {Tilted(19)}},
    {"angle_of_the_scene",
     {ExerciseErrorKind::kBadClip, "", 10 * kDegree},
     {},
     {Tilted(11)},
     {Tilted(9)}},
    {"coverage", kBadClip, {}, {Covering(0.979)}, {Covering(0.981)}},
    {"gap", kBadClip, {{Clip(0.01)}}, {Clip(0.0129)}, {Clip(0.0131)}},
    {"gap_on_the_other_side", kBadClip, {{Clip(0.01)}}, {Clip(0.0071)}, {Clip(0.0069)}},
    {"gap_to_a_bad_clip", kBadClip, {{Tilted(30)}}, {Clip(0.0129)}, {Clip(0.0131)}},
    {"end_b_in_the_body", kBadClip, {}, {Clip(kLength - 0.0034)}, {Clip(kLength - 0.0036)}},
    {"end_a_in_the_body", kBadClip, {}, {Clip(0.0034, kArtery)}, {Clip(0.0036, kArtery)}},
    {"end_at_the_organ", kBadClip, {}, {Clip(0.0034, kBranch)}, {Clip(0.001)}},
    {"wrong_duct", kWrongDuct, {}, {Clip(0.01, kBranch)}, {Clip(0.01, kArtery)}},
    {"wrong_organ", kWrongOrgan, {}, {Lost(), kBileDuct}, {Lost(), kLiverOrgan}},
    {"lost_clip", kLostClip, {}, {Lost()}, {Clip(0.01)}},
    {"early_cut", kEarlyCut, {{Clip(0.01)}, {Clip(0.015)}}, {Cut(0.012)}, {Clip(0.02)}},
    {"early_clip", kEarlyClip, {}, {Clip(0.01, kArtery)}, {Clip(0.01)}},
    {"cut_on_the_organs_side", kBadCut, kThreeClips, {Cut(0.0099)}, {Cut(0.0101)}},
    {"cut_that_leaves_one_clip", kBadCut, kThreeClips, {Cut(0.0151)}, {Cut(0.0149)}},
    {"second_cut",
     kBadCut,
     {{Clip(0.01, kArtery)}, {Clip(0.015, kArtery)}, {Clip(0.02, kArtery)}, {Cut(0.018, kArtery)}},
     {Cut(0.0149, kArtery)},
     {Cut(0.0151, kArtery)}},
    {"cut_of_the_artery", kBadCut, kArteryClips, {Cut(0.0149, kArtery)}, {Cut(0.0151, kArtery)}},
    {"cut_beside_a_loose_clip",
     kBadCut,
     {{Covering(0.9)}, {Clip(0.015)}, {Clip(0.02)}},
     {Cut(0.012)},
     {Clip(0.025)}},
};
INSTANTIATE_TEST_SUITE_P(Cases, DuctErrors, testing::ValuesIn(kDuctCases),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_P(DuctErrors, IsFoundWithItsPlaceAndDuct) {
  const DuctCase& c = GetParam();
  DuctCourse course(DuctExercise(c.error));
  for (const Act& act : c.before) course.Run(act);
  const std::size_t before = course.errors();
  course.Run(c.wrong);
  ASSERT_EQ(course.errors(), before + 1);
  const ExerciseError& error = course.result().errors.back();
  EXPECT_EQ(error.hand, 1);
  EXPECT_EQ(error.duct, c.wrong.action.duct);
  EXPECT_EQ(error.organ, c.wrong.pressed);
  EXPECT_EQ(error.place_W, c.wrong.action.place_W);
}

TEST_P(DuctErrors, ANearMissIsNotFlagged) {
  const DuctCase& c = GetParam();
  DuctCourse course(DuctExercise(c.error));
  for (const Act& act : c.before) course.Run(act);
  const std::size_t before = course.errors();
  course.Run(c.near_miss);
  EXPECT_EQ(course.errors(), before);
}

TEST(ExerciseDucts, AStepCountsGoodClipsAloneAndOnTheRightDuct) {
  DuctCourse course(DuctExercise(kBadClip));
  for (const Act& act : std::vector<Act>{{Clip(0.01)}, {Clip(0.02)}, {Tilted(30, 0.015)}}) {
    course.Run(act);
  }
  EXPECT_EQ(course.done(), 0u) << "the third is bad";
  EXPECT_DOUBLE_EQ(course.evaluator().Status().progress, 2.0 / 3);
  course.Run({Clip(0.025, kArtery)});
  EXPECT_EQ(course.done(), 0u);
  course.Run({Clip(0.024)});
  EXPECT_EQ(course.done(), 1u);
}

TEST(ExerciseDucts, ACutStepNeedsClipsOnBothSides) {
  for (const auto& [arc, done] : {std::pair(0.009, 1u), {0.012, 2u}, {0.018, 1u}}) {
    DuctCourse course(DuctExercise(kBadClip));
    for (const Act& act : kThreeClips) course.Run(act);
    ASSERT_EQ(course.done(), 1u);
    course.Run({Cut(arc)});
    EXPECT_EQ(course.done(), done) << arc;
    EXPECT_EQ(course.result().passed, done == 2u);
  }
}

TEST(ExerciseDucts, ADuctThatTheOrganDoesNotHoldIsCutBetweenTwoClipsOnEachSide) {
  for (const bool fourth : {false, true}) {
    DuctCourse course(DuctExercise(kBadCut));
    for (const double arc : {0.006, 0.01, 0.015}) course.Run({Clip(arc, kBranch)});
    if (fourth) course.Run({Clip(0.02, kBranch)});
    course.Run({Cut(0.012, kBranch)});
    EXPECT_EQ(course.errors(), fourth ? 0u : 1u);
  }
}

TEST(ExerciseDucts, AClipOnAWrongOrganIsNotLostToo) {
  ExerciseOptions exercise = DuctExercise(kWrongOrgan);
  exercise.errors.push_back(kLostClip);
  DuctCourse course(exercise);
  course.Run({Lost(), kBileDuct});
  ASSERT_EQ(course.errors(), 1u);
  EXPECT_EQ(course.result().errors[0].rule, 0);
  course.Run({Lost(), kLiverOrgan});
  ASSERT_EQ(course.errors(), 2u);
  EXPECT_EQ(course.result().errors[1].rule, 1);
}

TEST(ExerciseDucts, ADuctThatTheSceneDoesNotHaveCountsForNone) {
  DuctCourse course(DuctExercise(kBadClip));
  course.Run({Clip(0.01, 7)});
  course.Run({Cut(0.01, 7)});
  ASSERT_EQ(course.errors(), 1u) << "a clip on none of the ducts is not good";
  EXPECT_EQ(course.result().errors[0].duct, -1);
}

// The course's steps are kStepPeriod apart, the first at kStepPeriod.
class Bleedings : public testing::Test {
 protected:
  static constexpr double kStep = 1e-9 * kStepPeriod;  // s
  static ExerciseEvaluator Judge(double limit) {
    return ExerciseEvaluator(DuctExercise(
        {.kind = ExerciseErrorKind::kBleeding, .name = "bleeding", .limit = limit, .points = 7}));
  }
  static void Step(int number, ExerciseEvaluator* judge, const DuctAction& action = {}) {
    StepSample sample;
    sample.tool_count = 2;
    sample.step.number = static_cast<std::uint64_t>(number);
    sample.step.time_ns = sample.step.device_time_ns = number * kStepPeriod;
    sample.duct_actions[1] = action;
    judge->Add(sample);
  }
};

TEST_F(Bleedings, LastUntilTheNextClipThatHoldsADuct) {
  ExerciseEvaluator judge = Judge(1);
  for (int n = 0; n <= 5; ++n) Step(n, &judge);
  judge.AddBleeding(5 * kStepPeriod);
  EXPECT_TRUE(judge.result().bleedings.empty()) << "begins after the step of its time";
  Step(6, &judge, Lost());
  Step(7, &judge, Cut(0.01));
  ASSERT_EQ(judge.result().bleedings.size(), 1u);
  EXPECT_EQ(judge.BleedingsOver(), 0);
  Step(8, &judge, Clip(0.01, kBranch));
  Step(9, &judge);
  const ExerciseBleeding& bleeding = judge.result().bleedings[0];
  EXPECT_EQ(judge.BleedingsOver(), 1);
  EXPECT_NEAR(bleeding.begin, 5 * kStep, 1e-12);
  EXPECT_NEAR(bleeding.end, 8 * kStep, 1e-12);
  EXPECT_TRUE(judge.result().errors.empty());
}

// The first was stopped before, the second is open when the step begins, the third begins later.
TEST_F(Bleedings, ThatAreOpenAreOverByARestart) {
  ExerciseEvaluator judge = Judge(3.5 * kStep);
  Step(0, &judge);
  judge.AddBleeding(0);
  Step(1, &judge, Clip(0.01));
  const auto mark = [&judge](int number, int kept, int restarted) {
    StepSample sample;
    sample.tool_count = 2;
    sample.step.number = static_cast<std::uint64_t>(number);
    sample.step.time_ns = sample.step.device_time_ns = number * kStepPeriod;
    sample.step.kept_step = kept;
    sample.step.restarted_step = restarted;
    judge.Add(sample);
  };
  judge.AddBleeding(kStepPeriod);
  mark(2, 0, -1);
  judge.AddBleeding(2 * kStepPeriod);
  for (int n = 3; n <= 5; ++n) Step(n, &judge);
  EXPECT_EQ(judge.BleedingsOver(), 1);
  mark(6, -1, 0);
  EXPECT_EQ(judge.BleedingsOver(), 3);
  ASSERT_EQ(judge.result().bleedings.size(), 1u);
  for (int n = 7; n <= 15; ++n) Step(n, &judge);
  EXPECT_TRUE(judge.result().errors.empty());
  judge.AddBleeding(15 * kStepPeriod);
  Step(16, &judge);
  Step(17, &judge, Clip(0.02));
  EXPECT_EQ(judge.BleedingsOver(), 4);
}

TEST_F(Bleedings, AreAnErrorOnceAfterTheirLimit) {
  ExerciseEvaluator judge = Judge(3.5 * kStep);
  Step(0, &judge);
  judge.AddBleeding(0);
  for (int n = 1; n <= 3; ++n) Step(n, &judge);
  EXPECT_TRUE(judge.result().errors.empty()) << "a near miss";
  for (int n = 4; n <= 9; ++n) Step(n, &judge);
  ASSERT_EQ(judge.result().errors.size(), 1u);
  EXPECT_NEAR(judge.result().errors[0].time, 4 * kStep, 1e-12);
  judge.AddBleeding(9 * kStepPeriod);
  for (int n = 10; n <= 12; ++n) Step(n, &judge);
  Step(13, &judge, Clip(0.01));  // stops the older
  EXPECT_EQ(judge.result().errors.size(), 2u) << "the younger, after its own time";
  EXPECT_TRUE(judge.result().bleedings[0].stopped);
  EXPECT_FALSE(judge.result().bleedings[1].stopped);
}

// The log may have the event before the steps of its time and after: the result is the same.
TEST_F(Bleedings, OnlyTimesDecideNotTheOrderOfEventAndSteps) {
  std::vector<ExerciseResult> results;
  for (const int arrives : {0, 3, 6}) {  // before this step; the bleeding begins at step 6
    ExerciseEvaluator judge = Judge(2.5 * kStep);
    for (int n = 0; n <= 12; ++n) {
      if (n == arrives) judge.AddBleeding(6 * kStepPeriod);
      Step(n, &judge, n == 6 || n == 10 ? Clip(0.002 * n) : DuctAction());
    }
    results.push_back(judge.result());
  }
  for (const ExerciseResult& result : results) {
    ASSERT_EQ(result.bleedings.size(), 1u);
    EXPECT_EQ(result.bleedings[0].begin, results[0].bleedings[0].begin);
    EXPECT_EQ(result.bleedings[0].end, results[0].bleedings[0].end);
    EXPECT_TRUE(result.bleedings[0].stopped) << "by the clip after its begin";
    EXPECT_NEAR(result.bleedings[0].end - result.bleedings[0].begin, 4 * kStep, 1e-12);
    ASSERT_EQ(result.errors.size(), 1u);
    EXPECT_EQ(result.errors[0].time, results[0].errors[0].time);
  }
}

TEST(ExerciseDucts, ABadClipSaysEachFaultWithItsFigure) {
  DuctJudge judge({{"duct", 0}, {"artery", 1}, {"branch", -1}});
  const auto said = [&](const DuctAction& clip, bool keys = false) {
    const ClipFinding finding = judge.Examine(clip, 20 * kDegree);
    EXPECT_EQ(finding.faults == kClipSound, judge.IsGood(clip, 20 * kDegree));
    return FaultText(finding, "", keys);
  };
  EXPECT_EQ(said(Clip(0.01)), "");
  EXPECT_EQ(said(Tilted(38)), "oblique: 38\u00b0 (at most 20\u00b0)");
  EXPECT_EQ(said(Tilted(38), true),
            "oblique: 38\u00b0 (at most 20\u00b0): roll it (q, e) or turn the tube");
  EXPECT_EQ(said(Covering(0.979)), "covers 97 % of the width (at least 98 %)");
  judge.Keep(Clip(0.01), true);
  EXPECT_EQ(said(Clip(0.0124)), "1.4 mm from the next clip (at least 2 mm)");
  EXPECT_EQ(said(Clip(0.0105)), "on another clip");
  // The duct's end a is the organ's, and its end b stays.
  EXPECT_EQ(said(Clip(0.0025)), "") << "near the end that is taken out";
  EXPECT_EQ(said(Clip(kLength - 0.0026)), "2.1 mm from the end that stays (at least 3 mm)");
  EXPECT_EQ(said(Clip(0.0026, kArtery)), "2.1 mm from the end that stays (at least 3 mm)");
  DuctAction both = Tilted(25, kLength - 0.0026);
  EXPECT_EQ(said(both),
            "oblique: 25\u00b0 (at most 20\u00b0); 2.1 mm from the end that stays (at least 3 mm)");
  EXPECT_EQ(FaultText(judge.Examine(Tilted(38, 0.02), 20 * kDegree), "artery", false),
            "artery: oblique: 38\u00b0 (at most 20\u00b0)");
}

TEST(ExerciseDucts, AnErrorOfAClipHoldsItsFinding) {
  DuctCourse course(DuctExercise({.kind = ExerciseErrorKind::kBadClip, .limit = 15 * kDegree}));
  course.Run({Tilted(18)});
  ASSERT_EQ(course.errors(), 1u);
  const ClipFinding& clip = course.result().errors[0].clip;
  EXPECT_EQ(clip.faults, kClipOblique);
  EXPECT_NEAR(clip.angle, 18 * kDegree, 1e-12);
  EXPECT_NEAR(clip.most_angle, 15 * kDegree, 1e-12) << "of the rule";
  const ExerciseStatus status = course.evaluator().Status();
  EXPECT_EQ(status.last_error_clip.faults, kClipOblique);
  EXPECT_EQ(status.last_error_duct, kDuct);
  EXPECT_EQ(status.error_counts[0], 1);
  EXPECT_EQ(status.error_counts[1], 0);

  DuctCourse losing(DuctExercise({.kind = ExerciseErrorKind::kLostClip}));
  losing.Run({Lost()});
  DuctAction refused = Clip(0.01);
  refused.kind = DuctActionKind::kLostClip;
  losing.Run({refused});
  ASSERT_EQ(losing.errors(), 2u);
  EXPECT_EQ(losing.result().errors[0].clip.faults, kClipOnNothing);
  EXPECT_EQ(losing.result().errors[1].clip.faults, kClipRefused);
}

}  // namespace
}  // namespace hpdm
