// Judgement of exercises on made steps: every kind of error with a near miss beside it.

#include "engine/exercise/exercise_evaluator.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 33'333'333;
constexpr double kDt = 1e-9 * kPeriod;  // s
enum { kLiver, kGallbladder };
enum { kGrasper, kHook };     // hands
constexpr int kScissors = 1;  // of the left hand

ExerciseOptions Exercise(const ExerciseErrorOptions& error) {
  ExerciseOptions exercise;
  exercise.time_limit = 100;
  exercise.target_time = 20;
  exercise.steps.push_back({.name = "begin", .force = 100});
  exercise.steps.push_back({.name = "free", .frees = {0}, .freed_area = 1e-3});
  exercise.errors.push_back(error);
  exercise.hooks.push_back({kHook, 0});
  exercise.scissors.push_back({kGrasper, kScissors});
  return exercise;
}

// A session of two hands over two organs and one attachment.
class Course {
 public:
  explicit Course(ExerciseOptions exercise) : evaluator_(std::move(exercise)) {
    sample_.tool_count = 2;
    sample_.attachment_count = 1;
  }

  // Changes the state of the session and runs it for some steps.
  void Run(
      int steps, const std::function<void(StepSample*)>& change = [](StepSample*) {}) {
    change(&sample_);
    for (int i = 0; i < steps; ++i) {
      sample_.step.time_ns += kPeriod;
      if (!paused_) sample_.step.device_time_ns = sample_.step.time_ns;
      ++sample_.step.number;
      evaluator_.Add(sample_);
    }
  }
  // In a pause no device is read.
  void SetPaused(bool paused) { paused_ = paused; }
  const ExerciseResult& result() const { return evaluator_.result(); }
  ExerciseStatus status() const { return evaluator_.Status(); }
  std::size_t errors() const { return result().errors.size(); }

 private:
  StepSample sample_;
  ExerciseEvaluator evaluator_;
  bool paused_ = false;
};

void Touch(StepSample* sample, int hand, int organ, double force,
           ContactKind kind = ContactKind::kPress, double lift = 0) {
  SolvedContact& contact = sample->contacts[static_cast<std::size_t>(hand)];
  contact = {};
  contact.organ = organ;
  contact.kind = kind;
  contact.contact_W = Vector3d(0.01, 0.02, 0.03);
  contact.p_original_W = contact.contact_W - Vector3d(0, 0, lift);
  contact.force_on_tissue_W = Vector3d(0, force, 0);
}

struct ErrorCase {
  std::string name;
  ExerciseErrorOptions error;
  std::function<void(Course*, double)> commit;  // to a size
  double size, near_miss;
  int organ, hand;
  double force;
};
void PrintTo(const ErrorCase& c, std::ostream* out) { *out << c.name; }
class Errors : public testing::TestWithParam<ErrorCase> {};

// A press or a pull of so many N.
void Force(Course* course, double force) {
  course->Run(3, [&](StepSample* s) { Touch(s, kGrasper, kLiver, force); });
}
void ForceBeside(Course* course, double force) {
  course->Run(3, [&](StepSample* s) {
    Touch(s, kHook, kGallbladder, 1);
    s->beside[kHook][1] = s->contacts[kHook];
    s->beside[kHook][1].organ = kLiver;
    s->beside[kHook][1].force_on_tissue_W = Vector3d(0, 0, force);
  });
}
// A pull that frees so many m^2, beside as much that is burnt and cut.
void Tear(Course* course, double area) {
  course->Run(2, [&](StepSample* s) {
    Touch(s, kHook, kLiver, 0.5);
    Touch(s, kGrasper, kGallbladder, 1.5, ContactKind::kGrasp, 0.02);
    s->attachments[0].freed_area = 3 * area;
    s->attachments[0].burnt_area = s->attachments[0].cut_area = area;
  });
}
// A hook that is energised on the gallbladder, or in the air, for so many s.
void Burn(Course* course, double seconds) {
  course->Run(1, [&](StepSample* s) { Touch(s, kHook, kGallbladder, 0.2); });
  course->Run(static_cast<int>(seconds / kDt),
              [&](StepSample* s) { s->tools[kHook].pedal = true; });
  course->Run(3, [&](StepSample* s) { s->tools[kHook].pedal = false; });
}
void BurnAir(Course* course, double seconds) {
  course->Run(static_cast<int>(seconds / kDt),
              [&](StepSample* s) { s->tools[kHook].pedal = true; });
  course->Run(3, [&](StepSample* s) { s->tools[kHook].pedal = false; });
}
// A hook that is energised for 0.3 s so many m from the end of a line along x, and burns a layer there.
void BurnBeside(Course* course, double distance) {
  course->Run(9, [&](StepSample* s) {
    s->tools[kHook].X_WT.translation() = Vector3d(0.02, 0, 0) + distance * Vector3d(0.6, 0.8, 0);
    s->tools[kHook].pedal = true;
    s->layer_work[kHook].burning = 1;
  });
  course->Run(3, [&](StepSample* s) { s->tools[kHook].pedal = false; });
}
// The same with a gap of so many m to the second duct.
void BurnBesideDuct(Course* course, double gap) {
  course->Run(9, [&](StepSample* s) {
    s->tools[kHook].X_WT.translation() = Vector3d(0.01, 0.02, 0.03);
    s->tools[kHook].pedal = true;
    s->layer_work[kHook].burning = 1;
    s->near_ducts[kHook] = {1, gap};
  });
  course->Run(9, [&](StepSample* s) { s->near_ducts[kHook] = {0, 0}; });
  course->Run(3, [&](StepSample* s) { s->tools[kHook].pedal = false; });
}
// Scissors in the left hand that press and close to so much; the press ends as they do. Then the hook.
void CutInto(Course* course, double jaw) {
  course->Run(1, [&](StepSample* s) {
    s->tools[kGrasper].instrument_index = kScissors;
    s->tools[kGrasper].jaw = 0.9;
    s->tools[kHook].jaw = 0.9;
    Touch(s, kGrasper, kLiver, 0.2);
    Touch(s, kHook, kLiver, 0.2);
  });
  course->Run(2, [&](StepSample* s) {
    s->tools[kGrasper].jaw = jaw;
    s->tools[kHook].jaw = 0;
    Touch(s, kGrasper, kLiver, 0, ContactKind::kNone);
  });
}
// Jaws that open on what they hold so many m from its place.
void Drop(Course* course, double lift) {
  course->Run(
      5, [&](StepSample* s) { Touch(s, kGrasper, kGallbladder, 1.25, ContactKind::kGrasp, lift); });
  course->Run(5, [&](StepSample* s) { Touch(s, kGrasper, kGallbladder, 0, ContactKind::kNone); });
}
// Jaws that open on what they hold so many m beside (0.01, 0.02, 0.03).
void DropBeside(Course* course, double distance) {
  course->Run(5, [&](StepSample* s) {
    Touch(s, kGrasper, kGallbladder, 1.25, ContactKind::kGrasp, 0.1);
    s->contacts[kGrasper].contact_W.y() += distance;
  });
  course->Run(5, [&](StepSample* s) { Touch(s, kGrasper, kGallbladder, 0, ContactKind::kNone); });
}
void Invert(Course* course, double flag) {
  course->Run(3, [&](StepSample* s) { s->step.flags = flag > 0 ? kStepInverted : kStepShed; });
}

const ErrorCase kCases[] = {
    {"force", {ExerciseErrorKind::kForce, "", 4}, Force, 4.01, 3.99, kLiver, kGrasper, 4.01},
    {"force_of_a_further_contact",
     {ExerciseErrorKind::kForce, "", 4, kLiver},
     ForceBeside,
     4.01,
     3.99,
     kLiver,
     kHook,
     4.01},
    {"tear",
     {ExerciseErrorKind::kTear, "", 2e-5},
     Tear,
     2.01e-5,
     1.99e-5,
     kGallbladder,
     kGrasper,
     1.5},
    {"burn",
     {ExerciseErrorKind::kBurn, "", 0.3, kGallbladder},
     Burn,
     0.34,
     0.29,
     kGallbladder,
     kHook,
     0.2},
    {"stray_burn", {ExerciseErrorKind::kStrayBurn, "", 0.5}, BurnAir, 0.54, 0.49, -1, kHook, 0},
    {"near_burn",
     {.kind = ExerciseErrorKind::kNearBurn,
      .limit = 0.1,
      .path_W = {Vector3d::Zero(), Vector3d(0.02, 0, 0)},
      .within = 0.005},
     BurnBeside,
     0.0049,
     0.0051,
     -1,
     kHook,
     0},
    {"burn_near_a_duct",
     {.kind = ExerciseErrorKind::kNearBurn, .limit = 0.1, .ducts = {1}, .within = 0.001},
     BurnBesideDuct,
     0.00099,
     0.00101,
     -1,
     kHook,
     0},
    {"wrong_cut",
     {.kind = ExerciseErrorKind::kWrongCut, .organ = kLiver},
     CutInto,
     0.29,
     0.31,
     kLiver,
     kGrasper,
     0.2},
    {"drop",
     {ExerciseErrorKind::kDrop, "", 0.012},
     Drop,
     0.0121,
     0.0119,
     kGallbladder,
     kGrasper,
     1.25},
    {"drop_away_from_a_line",
     {.kind = ExerciseErrorKind::kDrop,
      .path_W = {Vector3d(0, 0.02, 0.03), Vector3d(0.05, 0.02, 0.03)},
      .within = 0.005},
     DropBeside,
     0.0051,
     0.0049,
     kGallbladder,
     kGrasper,
     1.25},
    {"inverted", {ExerciseErrorKind::kInverted, "", 0}, Invert, 1, 0, -1, -1, 0},
};
INSTANTIATE_TEST_SUITE_P(Cases, Errors, testing::ValuesIn(kCases),
                         [](const auto& param_info) { return param_info.param.name; });

TEST_P(Errors, IsFoundOnceWithItsTimePlaceAndForce) {
  const ErrorCase& c = GetParam();
  Course course(Exercise(c.error));
  course.Run(30);
  c.commit(&course, c.size);
  ASSERT_EQ(course.errors(), 1u);
  const ExerciseError& error = course.result().errors[0];
  EXPECT_EQ(error.organ, c.organ);
  EXPECT_EQ(error.hand, c.hand);
  EXPECT_DOUBLE_EQ(error.force, c.force);
  EXPECT_GE(error.time, 29 * kDt);
  EXPECT_LE(error.time, course.result().time);
  EXPECT_EQ(course.status().last_error, 0);
  EXPECT_EQ(course.status().errors, 1);
  EXPECT_EQ(error.step, 1);
  EXPECT_DOUBLE_EQ(course.result().score, 40 - 5) << "one step of two";
}

TEST_P(Errors, ANearMissIsNotFlagged) {
  const ErrorCase& c = GetParam();
  Course course(Exercise(c.error));
  course.Run(30);
  c.commit(&course, c.near_miss);
  EXPECT_EQ(course.errors(), 0u);
  EXPECT_DOUBLE_EQ(course.result().score, 40);
}

TEST(ExerciseEvaluator, AForceCountsAgainAfterItHasFallen) {
  Course course(Exercise({ExerciseErrorKind::kForce, "", 4}));
  for (const double force : {4.5, 3.5, 6.0, 5.0}) Force(&course, force);
  ASSERT_EQ(course.errors(), 1u) << "3.5 N is above 80 % of the limit";
  EXPECT_DOUBLE_EQ(course.result().errors[0].force, 6);
  for (const double force : {3.1, 4.5}) Force(&course, force);
  EXPECT_EQ(course.errors(), 2u);
}

TEST(ExerciseEvaluator, BurningTheLayerIsNoBurnOfAnOrganAndOtherHandsDoNotBurn) {
  Course course(Exercise({ExerciseErrorKind::kBurn, "", 0.3}));
  course.Run(60, [](StepSample* s) {
    Touch(s, kHook, kGallbladder, 0.2);
    Touch(s, kGrasper, kGallbladder, 1, ContactKind::kGrasp);
    s->tools[kHook].pedal = s->tools[kGrasper].pedal = true;
    s->layer_work[kHook].burning = 0.1;
  });
  EXPECT_EQ(course.errors(), 0u);
  course.Run(60, [](StepSample* s) {
    s->layer_work[kHook].burning = 0;
    s->tools[kHook].instrument_index = 1;  // the scissors
  });
  EXPECT_EQ(course.errors(), 0u);
  course.Run(60, [](StepSample* s) { s->tools[kHook].instrument_index = 0; });
  EXPECT_EQ(course.errors(), 1u);
}

TEST(ExerciseEvaluator, ADuctThatIsCutMayBeBurnt) {
  Course course(Exercise(
      {.kind = ExerciseErrorKind::kNearBurn, .limit = 0.1, .ducts = {1}, .within = 0.001}));
  course.Run(1, [](StepSample* s) { s->ducts[1].cuts = 1; });
  BurnBesideDuct(&course, 0);
  EXPECT_EQ(course.errors(), 0u);
}

TEST(ExerciseEvaluator, ShortPressesOfThePedalDoNotAddUpButEachLongOneCounts) {
  Course course(Exercise({ExerciseErrorKind::kBurn, "", 0.3}));
  for (int i = 0; i < 10; ++i) Burn(&course, 0.2);
  EXPECT_EQ(course.errors(), 0u);
  for (int i = 0; i < 9; ++i) Burn(&course, 0.4);
  EXPECT_EQ(course.errors(), 9u);
  EXPECT_DOUBLE_EQ(course.result().score, 0) << "40 - 45";
}

TEST(ExerciseEvaluator, NothingIsDroppedWhileOtherJawsHoldIt) {
  const auto hold = [](int hand, ContactKind kind) {
    return [=](StepSample* s) { Touch(s, hand, kGallbladder, 1, kind, 0.02); };
  };
  Course course(Exercise({ExerciseErrorKind::kDrop, "", 0.012}));
  course.Run(3, hold(kGrasper, ContactKind::kGrasp));
  course.Run(3, hold(kHook, ContactKind::kGrasp));
  course.Run(3, hold(kHook, ContactKind::kNone));
  EXPECT_EQ(course.errors(), 0u);
  course.Run(3, hold(kGrasper, ContactKind::kNone));
  EXPECT_EQ(course.errors(), 1u);
}

ExerciseOptions FourSteps() {
  ExerciseOptions exercise;
  exercise.time_limit = 10;
  exercise.target_time = 2;
  ExerciseStepOptions take{.name = "take", .holds = ExerciseContact{kGallbladder, {{kGrasper, 0}}}};
  take.time = 0.5;
  ExerciseStepOptions lift = take;
  lift.lift = 0.01;
  lift.time = 0;
  ExerciseStepOptions touch{.name = "touch", .touches = ExerciseContact{kLiver, {}}};
  touch.at_W = Vector3d(0.01, 0.02, 0.028);
  touch.within = 0.0021;
  touch.force = 0.5;
  exercise.steps = {take, lift, touch, {.name = "release", .releases = kGallbladder}};
  return exercise;
}

TEST(ExerciseEvaluator, StepsAreDoneInTheirOrderOnceTheirConditionsHaveHeld) {
  Course course(FourSteps());
  const auto hold = [](double lift) {
    return
        [lift](StepSample* s) { Touch(s, kGrasper, kGallbladder, 1, ContactKind::kGrasp, lift); };
  };
  course.Run(14, hold(0.02));
  EXPECT_EQ(course.status().step, 0);
  course.Run(1, [](StepSample* s) { Touch(s, kGrasper, kLiver, 1, ContactKind::kGrasp); });
  course.Run(15, hold(0.0099));
  EXPECT_EQ(course.status().step, 0) << "the break begins the time again";
  EXPECT_NEAR(course.status().progress, 14 * kDt / 0.5, 1e-6);
  course.Run(2);
  EXPECT_EQ(course.status().step, 1);
  course.Run(5);
  EXPECT_EQ(course.status().step, 1);
  EXPECT_NEAR(course.status().progress, 0.99, 1e-6) << "of the lift";
  course.Run(1, hold(0.0025));
  EXPECT_NEAR(course.status().progress, 0.25, 1e-6);
  course.Run(1, [](StepSample* s) { Touch(s, kGrasper, kLiver, 1, ContactKind::kGrasp, 0.02); });
  EXPECT_EQ(course.status().progress, 0) << "another organ";
  course.Run(1, hold(0.0101));
  EXPECT_EQ(course.status().step, 2);
  // The touch of 0.51 N is too strong, and so is the pull of the grasper.
  course.Run(3, [](StepSample* s) { Touch(s, kHook, kLiver, 0.4); });
  EXPECT_EQ(course.status().step, 2);
  course.Run(3, [](StepSample* s) {
    Touch(s, kGrasper, kGallbladder, 0.3, ContactKind::kGrasp, 0.01);
    Touch(s, kHook, kLiver, 0.51);
  });
  EXPECT_EQ(course.status().step, 2);
  course.Run(3, [](StepSample* s) {
    Touch(s, kHook, kLiver, 0.4);
    s->contacts[kHook].contact_W.x() += 0.001;
  });
  EXPECT_EQ(course.status().step, 2) << "beside the target";
  course.Run(1, [](StepSample* s) { Touch(s, kHook, kLiver, 0.4); });
  EXPECT_EQ(course.status().step, 3);
  EXPECT_FALSE(course.result().ended);
  EXPECT_DOUBLE_EQ(course.result().score, 60);
  course.Run(1, [](StepSample* s) { Touch(s, kGrasper, -1, 0, ContactKind::kNone); });
  EXPECT_TRUE(course.result().passed);
  EXPECT_DOUBLE_EQ(course.result().score, 100) << "before the target time";
  const double time = course.result().time;
  course.Run(10);
  EXPECT_EQ(course.result().time, time) << "nothing counts after the end";
}

// The first step is done at once. An error in the second one does not count once it begins again.
TEST(ExerciseEvaluator, ARestartReturnsToTheTimeErrorsAndScoreOfItsStep) {
  Course course(Exercise({.kind = ExerciseErrorKind::kForce, .limit = 4, .points = 5}));
  const auto press = [&course](double force) {
    course.Run(1, [force](StepSample* s) { Touch(s, kHook, kLiver, force); });
  };
  const auto mark = [&course](int kept, int restarted) {
    course.Run(1, [=](StepSample* s) {
      s->step.kept_step = kept;
      s->step.restarted_step = restarted;
    });
    // Run changes the sample that later calls continue with.
    course.Run(0, [](StepSample* s) { s->step.kept_step = s->step.restarted_step = -1; });
  };
  mark(0, -1);
  press(5);
  press(0);
  course.Run(27);
  const double begin = course.result().time;
  EXPECT_NEAR(begin, 29 * kDt, 1e-9);
  ASSERT_EQ(course.status().step, 1);
  ASSERT_EQ(course.errors(), 1u);
  const double score = course.result().score;
  mark(1, -1);
  press(6);
  press(0);
  course.Run(27);
  EXPECT_EQ(course.errors(), 2u);
  mark(-1, 1);
  EXPECT_NEAR(course.result().time, begin, 1e-12) << "as before the step that was kept";
  EXPECT_EQ(course.errors(), 1u);
  EXPECT_EQ(course.result().score, score);
  ASSERT_EQ(course.status().restarts, 1);
  const ExerciseRestart restart = course.result().restarts[0];
  EXPECT_EQ(restart.step, 1);
  EXPECT_EQ(restart.errors, 1);
  EXPECT_NEAR(restart.discarded, 30 * kDt, 1e-9);
  EXPECT_NEAR(course.status().restarted, begin, 1e-12);
  course.Run(30);
  EXPECT_NEAR(course.result().time, begin + 30 * kDt, 1e-9) << "it goes on";
  mark(-1, 0);
  EXPECT_EQ(course.status().step, 1) << "the first step is done at once";
  EXPECT_EQ(course.errors(), 0u);
  EXPECT_EQ(course.status().restarts, 2);
  course.Run(1, [](StepSample* s) { s->attachments[0].freed_area = 2e-3; });
  EXPECT_TRUE(course.result().passed);
  mark(-1, 0);
  EXPECT_TRUE(course.result().passed) << "after the end nothing changes";
}

// The step began with open jaws; they have been closed since.
TEST(ExerciseEvaluator, JawsThatAreClosedDoNotCloseByARestart) {
  Course course(Exercise({.kind = ExerciseErrorKind::kWrongCut, .organ = kLiver}));
  const auto step = [&course](double jaw, int kept, int restarted) {
    course.Run(1, [=](StepSample* s) {
      s->tools[kGrasper].instrument_index = kScissors;
      s->tools[kGrasper].jaw = jaw;
      s->step.kept_step = kept;
      s->step.restarted_step = restarted;
    });
  };
  step(0.9, -1, -1);
  step(0.9, 1, -1);
  step(0, -1, -1);
  course.Run(0, [](StepSample* s) { Touch(s, kGrasper, kLiver, 0.2); });
  step(0, -1, 1);
  EXPECT_EQ(course.status().restarts, 1);
  EXPECT_EQ(course.errors(), 0u);
}

TEST(ExerciseEvaluator, LateStepsGiveNoTimePointsAndTheLimitEndsIt) {
  const auto hold = [](StepSample* s) {
    Touch(s, kGrasper, kGallbladder, 0.2, ContactKind::kGrasp, 0.02);
  };
  const auto finish = [](StepSample* s) {
    Touch(s, kGrasper, -1, 0, ContactKind::kNone);
    Touch(s, kHook, kLiver, 0.4);
  };
  Course late(FourSteps());
  late.Run(179, hold);
  late.Run(1, finish);  // touched
  late.Run(1);          // released
  ASSERT_TRUE(late.result().passed);
  const double share = 1 - (180 * kDt - 2) / 8;
  EXPECT_NEAR(late.result().score, 80 + 20 * share, 1e-9);
  Course never(FourSteps());
  never.Run(310, hold);
  EXPECT_TRUE(never.result().ended);
  EXPECT_FALSE(never.result().passed);
  EXPECT_DOUBLE_EQ(never.result().time, 10);
  EXPECT_DOUBLE_EQ(never.result().score, 40);
}

TEST(ExerciseEvaluator, TheTimeStandsInAPause) {
  Course course(Exercise({.kind = ExerciseErrorKind::kForce, .limit = 4}));
  course.Run(31);
  EXPECT_NEAR(course.result().time, 30 * kDt, 1e-9);
  course.SetPaused(true);
  course.Run(300);  // 10 s
  // The first steps of a pause have a reading that is not yet older than kStandsAfter.
  const double counted = course.result().time - 30 * kDt;
  EXPECT_GT(counted, 0);
  EXPECT_LE(counted, ToSeconds(ExerciseEvaluator::kStandsAfter));
  EXPECT_NEAR(course.result().stood, 300 * kDt - counted, 1e-9);
  const double before = course.status().time_left;
  course.Run(100);
  EXPECT_EQ(course.status().time_left, before);
  course.SetPaused(false);
  course.Run(30);
  EXPECT_NEAR(course.result().time, 60 * kDt + counted, 1e-9) << "it goes on where it stood";
}

TEST(ExerciseEvaluator, APauseDoesNotEndTheExerciseNorCompleteAStepThatMustLast) {
  ExerciseOptions options = Exercise({.kind = ExerciseErrorKind::kForce, .limit = 4});
  options.steps[0].time = 2;
  Course course(options);
  course.Run(31);  // 1 s of 2
  course.SetPaused(true);
  course.Run(4000);  // beyond the time limit of 100 s
  EXPECT_FALSE(course.result().ended);
  EXPECT_TRUE(course.result().step_times.empty());
  course.SetPaused(false);
  course.Run(31);
  EXPECT_EQ(course.result().step_times.size(), 1u);
}

}  // namespace
}  // namespace hpdm
