#include "tools/report/metrics/session_comparison.h"

#include <gtest/gtest.h>

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

MetricDifference Compare(const char* key, double now, double before, bool may_judge = true) {
  return CompareMetric(*FindMetric(key), now, before, may_judge);
}

SessionReport SessionOf(const std::string& log, const std::vector<std::string>& instruments) {
  SessionReport report;
  report.log = log;
  report.scene = "liver";
  report.organs = {"liver"};
  report.active = report.duration = 60;
  for (const std::string& name : instruments) {
    HandReport& hand = report.hands.emplace_back();
    hand.name = name;
    hand.held = {{0, name}};
  }
  return report;
}

TEST(CompareMetric, ASmootherMotionIsBetterByItsOwnUnit) {
  const MetricDifference smoother = Compare("smoothness_sparc", -1.42, -1.60);
  EXPECT_NEAR(*smoother.value, 0.18, 1e-9);
  EXPECT_EQ(smoother.verdict, MetricDifference::kBetter);
  EXPECT_EQ(Compare("smoothness_sparc", -1.60, -1.42).verdict, MetricDifference::kWorse);
}

TEST(CompareMetric, AnIdleTimeThatWasNearZeroDiffersInSeconds) {
  const MetricDifference idle = Compare("idle_s", 15.1, 0.1);
  EXPECT_NEAR(*idle.value, 15, 1e-9);
  EXPECT_EQ(idle.verdict, MetricDifference::kWorse);
  EXPECT_EQ(*Compare("idle_s", 1, 0).value, 1);
}

TEST(CompareMetric, TheDifferenceIsThatOfTheDisplayedNumbers) {
  const MetricDifference deepest = Compare("deepest_press_m", 0.0212, 0.0190);
  EXPECT_NEAR(*deepest.value, 2.2, 1e-9) << "mm";
  EXPECT_EQ(deepest.verdict, MetricDifference::kWorse);
  // 1.234 N and 1.226 N are displayed as 1.23 N.
  EXPECT_EQ(Compare("peak_force_N", 1.234, 1.226).verdict, MetricDifference::kSame);
  EXPECT_EQ(*Compare("peak_force_N", 1.234, 1.226).value, 0);
}

TEST(CompareMetric, WithoutAJudgementThereIsNoBetterAndNoWorse) {
  EXPECT_EQ(Compare("peak_force_N", 1, 2, false).verdict, MetricDifference::kUnjudged);
  EXPECT_EQ(Compare("peak_force_N", 2, 2, false).verdict, MetricDifference::kSame);
  EXPECT_EQ(Compare("mean_speed_m_per_s", 1, 2).verdict, MetricDifference::kUnjudged);
  EXPECT_FALSE(CompareMetric(*FindMetric("smoothness_sparc"), nullptr, -1.4, true).value);
  EXPECT_FALSE(CompareMetric(*FindMetric("smoothness_sparc"), -1.4, Json(), true).value);
}

TEST(CompareTasks, WarnsOfAnotherSceneInstrumentOrLength) {
  const SessionReport now = SessionOf("a/session.lcmlog", {"probe"});
  SessionReport before = SessionOf("b/session.lcmlog", {"probe"});
  before.active = 57;
  EXPECT_TRUE(CompareTasks(now, before).warnings.empty());

  before.active = 30;
  TaskComparison task = CompareTasks(now, before);
  ASSERT_EQ(task.warnings.size(), 1u);
  EXPECT_NE(task.warnings[0].find("60.0 s; before: 30.0 s"), std::string::npos);
  EXPECT_FALSE(task.same_length);
  EXPECT_TRUE(task.MayJudge()) << "who is faster may be better";

  before = SessionOf("b/session.lcmlog", {"grasper"});
  task = CompareTasks(now, before);
  EXPECT_EQ(task.warnings, std::vector<std::string>{"other instruments: probe; before: grasper"});
  EXPECT_FALSE(task.MayJudge());

  before = SessionOf("b/session.lcmlog", {"probe"});
  before.scene = "abdomen";
  task = CompareTasks(now, before);
  EXPECT_EQ(task.warnings, std::vector<std::string>{"another scene: liver; before: abdomen"});
  EXPECT_FALSE(task.MayJudge());

  before.scene = "";  // a bare log
  before.organs = {"liver", "stomach"};
  EXPECT_FALSE(CompareTasks(now, before).same_scene) << "its organs are others";
  before.organs = now.organs;
  EXPECT_TRUE(CompareTasks(now, before).same_scene);
}

TEST(CompareTasks, JudgesNothingIfOneSessionAloneTouchedTissue) {
  const SessionReport idle = SessionOf("a/session.lcmlog", {"probe"});
  SessionReport press = SessionOf("b/session.lcmlog", {"probe"});
  press.hands[0].contact = {.time = 10, .count = 4, .peak_force = 2};
  for (const auto& [now, before] : {std::pair(idle, press), std::pair(press, idle)}) {
    const TaskComparison task = CompareTasks(now, before);
    ASSERT_EQ(task.warnings.size(), 1u);
    EXPECT_NE(task.warnings[0].find("no figure is called better or worse"), std::string::npos);
    EXPECT_FALSE(task.MayJudge());
    const Json differences = ComparisonToJson(now, before)["hands"][0]["differences"];
    EXPECT_EQ(differences["peak_force_N"]["verdict"], nullptr);
  }
  EXPECT_TRUE(CompareTasks(idle, idle).MayJudge());
  EXPECT_TRUE(CompareTasks(press, press).MayJudge());
}

TEST(SessionNames, AreAsShortAsTheyMayBe) {
  const auto names = [](const std::string& a, const std::string& b) {
    return SessionNames(SessionOf(a, {}), SessionOf(b, {}));
  };
  using Names = std::pair<std::string, std::string>;
  EXPECT_EQ(names("/t/ann_1/session.lcmlog", "/t/ann_2/session.lcmlog"), Names("ann_1", "ann_2"));
  EXPECT_EQ(names("/t/ann/first/session.lcmlog", "/t/bob/first/session.lcmlog"),
            Names("ann/first", "bob/first"));
  EXPECT_EQ(names("/t/ann.lcmlog", "/t/bob/session.lcmlog"), Names("ann.lcmlog", "bob"));
  EXPECT_EQ(names("/t/ann/session.lcmlog", "/t/ann/session.lcmlog"), Names("ann", "ann"));
}

}  // namespace
}  // namespace hpdm
