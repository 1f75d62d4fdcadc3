// Tests the names and figures of the hands of a session.

#include <gtest/gtest.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/made_session.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/session_comparison.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {
namespace {

/// Adds ticks in which both hands exchange their instruments.
void Exchange(MadeSession* session) {
  for (int i = 0; i < 40; ++i) {
    session->Tick([i](HapticSample* sample) {
      sample->tools[0].instrument_index = i < 20 ? 0 : 1;
      sample->tools[1].instrument_index = i < 10 ? 1 : (i < 30 ? 0 : 2);
    });
  }
}

TEST(SessionHands, AHandIsLabelledWithAllThatItHeld) {
  MadeSession session({"grasper", "grasper"});  // both hands have the same names
  Exchange(&session);
  const SessionReport report = session.Finish().report;
  EXPECT_EQ(report.hands[0].Label(), "grasper, then hook");
  EXPECT_EQ(report.hands[1].Label(), "hook, then grasper, then blunt");
  EXPECT_EQ(report.hands[1].name, "grasper");
}

TEST(SessionHands, ALeftHandedSessionIsKnownByItsLogAndNotComparedWithARightHandedOne) {
  MadeSession left({"grasper", "hook"}, {}, {}, true), right({"grasper", "hook"});
  for (MadeSession* session : {&left, &right}) session->Press(300, 1, 0);
  const SessionReport a = left.Finish().report, b = right.Finish().report;
  EXPECT_TRUE(a.left_handed);
  EXPECT_FALSE(b.left_handed);
  EXPECT_EQ(ToJson(a)["left_handed"], true);
  EXPECT_EQ(a.events[1].text, "grasper and hook have exchanged their ports");
  const TaskComparison task = CompareTasks(a, b);
  EXPECT_FALSE(task.MayJudge());
  ASSERT_EQ(task.warnings.size(), 1u);
  EXPECT_EQ(task.warnings[0], "left-handed ports; before: right-handed");
  EXPECT_TRUE(CompareTasks(a, a).MayJudge());
}

TEST(SessionHands, TheWordingOfEventsDoesNotChangeTheFigures) {
  MadeSession session({"probe", "grasper"});
  Exchange(&session);
  const auto expected = ToJson(session.Finish().report);
  int changed = 0;
  const SessionReport reworded =
      session
          .Read([&changed](LogEvent* event) {
            event_t message;
            if (event->channel == kEventChannel && DecodeMessage(event->data, &message) &&
                message.name != "session.start") {
              message.text = "die Hand nimmt: the hand holds x now";
              EncodeMessage(message, &event->data);
              ++changed;
            }
            return true;
          })
          .report;
  EXPECT_EQ(changed, 5) << "four exchanges and the end";
  auto json = ToJson(reworded);
  for (const char* key : {"log", "log_health", "events"}) json[key] = expected[key];
  EXPECT_EQ(json, expected);
}

TEST(SessionHands, WithoutTheSessionsSceneExchangesHaveNumbers) {
  MadeSession session({"probe", "grasper"});
  Exchange(&session);
  session.Finish();
  using Names = std::vector<std::vector<std::string>>;
  const Names another = {{"probe", "hook", "blunt"}, {"scissors", "hook", "blunt"}};
  const Names fewer = {{"probe"}, {"grasper"}};
  for (const Names& instruments : {Names(), another, fewer}) {
    const SessionReport report = ReadSession(session.log(), kDefaultForceLimit, instruments).report;
    EXPECT_EQ(report.hands[0].Label(), "probe, then exchange 1");
    EXPECT_EQ(report.hands[1].Label(), "exchange 1, then grasper, then exchange 2");
  }
}

TEST(SessionHands, TwoHandsAreMeasuredSeparately) {
  MadeSession session({"probe", "grasper"});
  for (int i = 0; i < 2000; ++i) {
    session.Tick([i](HapticSample* sample) {
      // The first moves all the time, the second in the last quarter.
      sample->tools[0].p_tip_W.x() = 2e-5 * i;
      sample->tools[1].p_tip_W.y() = 2e-5 * std::max(0, i - 1500);
    });
  }
  const SessionReport report = session.Finish().report;
  ASSERT_EQ(report.hands.size(), 2u);
  EXPECT_EQ(report.hands[1].name, "grasper");
  EXPECT_NEAR(report.hands[0].motion.path_length, 0.04, 0.01 * 0.04);
  EXPECT_NEAR(report.hands[1].motion.path_length, 0.01, 0.01 * 0.04);
  EXPECT_NEAR(report.both_moving.value(), 0.5, 0.05);  // a filter's width
}

}  // namespace
}  // namespace hpdm
