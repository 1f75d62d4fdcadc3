#include "tools/report/metrics/report_json.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "tests/support/made_session.h"

namespace hpdm {
namespace {

TEST(ReportJson, ALayerHasItsLargestLoadAndItsLastDamage) {
  MadeSession session;
  session.Press(40, 2, 0);
  session.Step({{}, {.load_W = {0, 3, 4}, .largest_damage = 0.5, .dissipated = 1e-3}});
  session.Press(40, 2, 0);
  session.Step(
      {{}, {.load_W = {1, 0, 0}, .largest_damage = 1, .freed_area = 2e-4, .dissipated = 3e-3}});
  const SessionReport report = session.Finish().report;
  ASSERT_EQ(report.attachments.size(), 2u);
  EXPECT_EQ(report.attachments[0].peak_load, 0);
  const auto layer = ToJson(report)["attachments"][1];
  EXPECT_EQ(layer["name"], "attachment 2");
  EXPECT_EQ(layer["peak_load_N"], 5);
  EXPECT_EQ(layer["largest_damage"], 1);
  EXPECT_EQ(layer["freed_area_m2"], 2e-4);
  EXPECT_EQ(layer["dissipated_J"], 3e-3);
}

TEST(ReportJson, KeysCarryUnits) {
  MadeSession session;
  session.Press(300, 2, 0);
  const auto json = ToJson(session.Finish().report);
  const auto& hand = json["hands"][0];
  for (const char* key : {"time_s",
                          "path_length_m",
                          "angular_path_rad",
                          "roll_path_rad",
                          "insertion_path_m",
                          "economy_of_motion",
                          "movements",
                          "mean_speed_m_per_s",
                          "peak_speed_m_per_s",
                          "smoothness_sparc",
                          "idle_s",
                          "contact_time_s",
                          "contacts",
                          "peak_force_N",
                          "mean_force_N",
                          "force_impulse_Ns",
                          "over_limit_s",
                          "over_limit_count",
                          "deepest_press_m",
                          "over_depth_s",
                          "over_depth_count",
                          "depth_unknown_s",
                          "mean_force_rate_N_per_s",
                          "peak_force_rate_N_per_s",
                          "device_lost_s",
                          "organs"}) {
    EXPECT_TRUE(hand.contains(key)) << key;
  }
  EXPECT_TRUE(hand["economy_of_motion"].is_null());
  EXPECT_EQ(hand["organs"][0]["organ"], "liver");
  EXPECT_EQ(json["start"], nullptr);
  EXPECT_EQ(json["log_health"]["sound"], true);
}

// The session's clock runs for 2.07 s before the first tick, and a bleeding's time is that clock's.
TEST(ReportJson, EventsStepsAndErrorsCountFromTheFirstTick) {
  ExerciseOptions exercise;
  exercise.time_limit = 10;
  exercise.target_time = 5;
  exercise.steps = {{.name = "touch", .touches = ExerciseContact{1, {}}},
                    {.name = "again", .time = 9}};
  exercise.errors = {{.name = "too strong", .limit = 3}};
  MadeSession session({"probe"}, {}, exercise);
  session.Skip(2070);
  session.Press(1, 0, -1);
  session.PressStep(0, -1);  // the first step
  session.Press(500, 0, -1);
  session.Press(1, 4, 1);
  session.PressStep(4, 1);
  session.Press(100, 0, -1);
  const SessionReading reading = session.Finish();
  const auto json = ToJson(reading.report);
  std::map<std::string, double> times;
  for (const auto& event : json["events"]) times[event["name"]] = event["time_s"];
  const double error = json["exercise"]["errors"][0]["time_s"];
  constexpr double kTick = 0.001;
  EXPECT_NEAR(error, 0.501, 1e-9);
  EXPECT_NEAR(times.at("exercise.error"), error, kTick + 1e-9);
  EXPECT_NEAR(times.at("exercise.step"), json["exercise"]["steps"][0]["done_s"], kTick + 1e-9);
  EXPECT_NEAR(times.at("session.start"), -2.07, 1e-9);
  EXPECT_EQ(reading.series.start, 0);
  EXPECT_NEAR(reading.series.hands[0].segments[0].start, 0, kMotionPeriod);
}

// The second lumen, the gallbladder's, begins to leak; the hook had warmed it, which is no error, and a hole
// in the liver's lumen is none of this rule.
TEST(ReportJson, APerforationIsAnErrorOfTheLogAsOfTheSessionAndNamesTheInstrumentThatWasHeld) {
  ExerciseOptions exercise;
  exercise.time_limit = 10;
  exercise.target_time = 5;
  exercise.organs = {"liver", "gallbladder"};
  exercise.hooks = {{0, 1}};
  exercise.steps = {{.name = "never", .touches = ExerciseContact{1, {}}, .time = 9}};
  exercise.errors = {
      {.kind = ExerciseErrorKind::kPerforation, .name = "hole", .organ = 1, .points = 7}};
  MadeSession session({"probe"}, {}, exercise);
  const auto run = [&](int steps, bool liver, bool gallbladder) {
    for (int step = 0; step < steps; ++step) {
      for (int tick = 0; tick < 33; ++tick) {
        session.Tick([](HapticSample* sample) { sample->tools[0].instrument_index = 1; });
      }
      session.LumenStep({{.perforated = liver}, {.pressure = 900, .perforated = gallbladder}}, 1);
    }
  };
  run(10, false, false);
  run(10, true, false);
  EXPECT_EQ(session.telemetry().Summary().exercise->errors.size(), 0u);
  run(10, true, true);
  const ExerciseResult live = session.telemetry().Summary().exercise.value();
  ASSERT_EQ(live.errors.size(), 1u);
  EXPECT_NEAR(live.errors[0].time, 0.66, 0.034);
  const SessionReport report = session.Finish().report;
  const ExerciseResult& read = report.exercise->result;
  ASSERT_EQ(read.errors.size(), 1u);
  EXPECT_EQ(read.errors[0].time, live.errors[0].time);
  const auto error = ToJson(report)["exercise"]["errors"][0];
  EXPECT_EQ(error["name"], "hole");
  EXPECT_EQ(error["organ"], "gallbladder");
  EXPECT_EQ(error["hand"], 0);
  EXPECT_EQ(error["instrument"], "hook");
  EXPECT_EQ(error["points"], 7);
}

TEST(ReportJson, APerforationIsFoundByTheNameOfItsOrgan) {
  const std::vector<std::string> organs = {"gall", "gallbladder", "liver number 2"};
  EXPECT_EQ(PerforatedOrgan(PerforatedText(LumenName("gallbladder")), organs), 1);
  EXPECT_EQ(PerforatedOrgan(PerforatedText(LumenName("gall", 12)), organs), 0);
  EXPECT_EQ(PerforatedOrgan(PerforatedText(LumenName("liver number 2")), organs), 2);
  EXPECT_EQ(PerforatedOrgan(PerforatedText(LumenName("lung")), organs), -1);
  EXPECT_EQ(PerforatedOrgan("", organs), -1);
}

// A touch that is too strong, then a soft one: the report of the log judges as the session did.
TEST(ReportJson, AnExerciseIsJudgedByTheLogAsItWasInTheSession) {
  ExerciseOptions exercise;
  exercise.name = "touch";
  exercise.time_limit = 10;
  exercise.target_time = 0.1;
  ExerciseStepOptions touch{.name = "touch", .touches = ExerciseContact{1, {}}};
  touch.force = 2;
  touch.time = 0.2;
  exercise.steps = {touch, {.name = "again", .force = 1.0 / 3}};
  exercise.errors = {{.name = "too strong", .limit = 3, .points = 7}};
  MadeSession session({"probe"}, {}, exercise);
  const auto press = [&](double force, int steps) {
    for (int step = 0; step < steps; ++step) {
      session.Press(33, force, 1);
      session.PressStep(force, 1);
    }
  };
  press(3.1, 5);
  // A pause of 13 s, beyond the time limit.
  for (int step = 0; step < 400; ++step) {
    for (int tick = 0; tick < 33; ++tick) {
      session.Tick([](HapticSample* sample) { sample->paused = true; });
    }
    session.PressStep(3.1, 1);
  }
  EXPECT_FALSE(session.telemetry().ExerciseEnded()) << "the time stands in a pause";
  press(1.0 / 3, 6);
  EXPECT_FALSE(session.telemetry().ExerciseEnded());
  press(1.0 / 3, 10);
  EXPECT_TRUE(session.telemetry().ExerciseEnded());
  const ExerciseResult live = session.telemetry().Summary().exercise.value();
  const SessionReport report = session.Finish().report;
  ASSERT_TRUE(report.exercise.has_value());
  const ExerciseResult& read = report.exercise->result;
  EXPECT_TRUE(live.passed);
  EXPECT_EQ(read.score, live.score);
  EXPECT_EQ(read.step_times, live.step_times);
  EXPECT_EQ(read.time, live.time);
  EXPECT_EQ(read.stood, live.stood);
  EXPECT_NEAR(live.stood, 400 * 0.033, 0.15);
  ASSERT_EQ(read.errors.size(), 1u);
  EXPECT_EQ(read.errors[0].force, live.errors[0].force);
  const auto json = ToJson(report)["exercise"];
  EXPECT_EQ(json["score"], live.score);
  EXPECT_EQ(json["steps"][0]["name"], "touch");
  EXPECT_EQ(json["steps"][0]["done_s"], live.step_times[0]);
  EXPECT_EQ(json["errors"][0]["name"], "too strong");
  EXPECT_EQ(json["errors"][0]["organ"], "gallbladder");
  EXPECT_EQ(json["errors"][0]["force_N"], 3.1);
  EXPECT_EQ(json["errors"][0]["clip_faults"], "");
  EXPECT_EQ(json["stood_s"], live.stood);
  EXPECT_EQ(json["errors"][0]["place_m"][2], 0.03);
  MadeSession without;
  without.Press(33, 1, 1);
  EXPECT_FALSE(ToJson(without.Finish().report).contains("exercise"));
}

// The teacher's event comes between ticks; the log has it before the steps of its time.
TEST(ReportJson, ABleedingOfTheTeacherLastsAsLongInTheLogAsInTheSession) {
  ExerciseOptions exercise;
  exercise.time_limit = 10;
  exercise.steps = {{.name = "free", .frees = {0}, .freed_area = 1}};
  exercise.errors = {{.kind = ExerciseErrorKind::kBleeding, .name = "bleeding", .limit = 0.2}};
  exercise.ducts = {{.name = "duct"}};
  SpscQueue<LoopEvent> events(8);
  TelemetryOptions options;
  options.events = {&events};
  MadeSession session({"clip applier"}, options, exercise);
  const auto run = [&session](int steps) {
    for (int step = 0; step < steps; ++step) {
      session.Press(33, 0, -1);
      session.PressStep(0, -1);
    }
  };
  run(5);
  events.Push(MakeLoopEvent(EventSeverity::kInfo, kBleeding, "a bleeding begins"));
  run(10);
  EXPECT_EQ(session.telemetry().BleedingsOver(), 0);
  session.Press(33, 0, -1);
  session.ClipStep();
  EXPECT_EQ(session.telemetry().BleedingsOver(), 1);
  run(3);
  const ExerciseResult live = session.telemetry().Summary().exercise.value();
  const SessionReport report = session.Finish().report;
  const ExerciseResult& read = report.exercise->result;
  ASSERT_EQ(live.bleedings.size(), 1u);
  ASSERT_EQ(read.bleedings.size(), 1u);
  EXPECT_EQ(read.bleedings[0].begin, live.bleedings[0].begin);
  EXPECT_EQ(read.bleedings[0].end, live.bleedings[0].end);
  EXPECT_NEAR(live.bleedings[0].end - live.bleedings[0].begin, 11 * 0.033, 0.034);
  EXPECT_TRUE(read.bleedings[0].stopped);
  ASSERT_EQ(read.errors.size(), 1u);
  EXPECT_EQ(read.errors[0].time, live.errors[0].time);
  EXPECT_EQ(read.score, live.score);
  const auto json = ToJson(report)["exercise"]["bleedings"];
  ASSERT_EQ(json.size(), 1u);
  EXPECT_EQ(json[0]["stopped"], true);
  EXPECT_EQ(json[0]["lasted_s"], live.bleedings[0].end - live.bleedings[0].begin);
  const auto named = [&report](const std::string& name) {
    return std::ranges::count(report.events, name, &SessionEvent::name);
  };
  EXPECT_EQ(named("exercise.bleeding_stopped"), 1);
}

}  // namespace
}  // namespace hpdm
