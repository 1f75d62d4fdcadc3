// The estimated GOALS domains: each figure decides its domain alone, and what is unknown has no rating.

#include "tools/report/metrics/goals.h"

#include <gtest/gtest.h>

#include <string>

#include "tests/support/made_session.h"
#include "tests/support/read_file.h"
#include "tools/report/metrics/report_json.h"

namespace hpdm {
namespace {

enum { kDepthDomain, kBimanualDomain, kEfficiencyDomain, kTissueDomain, kAutonomyDomain };

/// Two hands that do everything as the best value of each scale.
SessionReport BestSession() {
  SessionReport report;
  report.active = 100;
  report.work = WorkTimes{.any_moves = 80, .together = 48};
  report.hands.resize(2);
  for (HandReport& hand : report.hands) {
    hand.motion.time = 100;
    hand.motion.path_length = 2;
    hand.motion.economy = 0.8;
    hand.motion.advances = 20;
    hand.motion.overshoots = 1;
    hand.contact.time = 30;
    hand.contact.peak_force = 2.4;
  }
  report.attachments.resize(1);
  ExerciseReport exercise;
  exercise.options.time_limit = 100;
  exercise.options.target_time = 60;
  exercise.options.errors = {{.kind = ExerciseErrorKind::kDrop},
                             {.kind = ExerciseErrorKind::kEarlyClip}};
  exercise.result.time = 60;
  exercise.result.ended = exercise.result.passed = true;
  report.exercise = exercise;
  return report;
}

double RatingOf(const SessionReport& report, std::size_t domain) {
  return RateGoals(report)[domain].rating.value_or(-1);
}

TEST(Goals, TheBestFiguresGiveFiveAndAutonomyIsNotRated) {
  const std::vector<GoalsDomain> domains = RateGoals(BestSession());
  ASSERT_EQ(domains.size(), 5u);
  for (std::size_t d = 0; d < kAutonomyDomain; ++d) {
    EXPECT_EQ(domains[d].rating, 5.0) << domains[d].label;
    EXPECT_EQ(domains[d].why_not, "");
  }
  EXPECT_FALSE(domains[kAutonomyDomain].rating.has_value());
  EXPECT_NE(domains[kAutonomyDomain].why_not, "");
}

TEST(Goals, OvershootsDecideDepthPerception) {
  SessionReport report = BestSession();
  report.hands[0].motion.overshoots = 10;  // 11 of 40, the middle of 5 and 50 %
  EXPECT_NEAR(RatingOf(report, kDepthDomain), 3, 1e-12);
  report.hands[0].motion.overshoots = 20;
  EXPECT_EQ(RatingOf(report, kDepthDomain), 1);
  report.hands[0].motion.advances = 4;
  report.hands[1].motion.advances = 0;
  EXPECT_EQ(RatingOf(report, kDepthDomain), -1);
}

TEST(Goals, WorkOfBothHandsDecidesBimanualDexterity) {
  SessionReport report = BestSession();
  report.work->together = 28;  // 35 %
  EXPECT_NEAR(RatingOf(report, kBimanualDomain), 3, 1e-12);
  report.work->together = 0;
  EXPECT_EQ(RatingOf(report, kBimanualDomain), 1);
  report.work.reset();
  EXPECT_EQ(RatingOf(report, kBimanualDomain), -1);
}

TEST(Goals, EfficiencyIsTheMeanOfItsFigures) {
  SessionReport report = BestSession();
  report.hands[0].motion.economy = 0.3;  // 0.55 on the whole: 3
  EXPECT_NEAR(RatingOf(report, kEfficiencyDomain), 4.3, 1e-12);
  report.work->any_moves = 30;  // 70 % still: 1
  EXPECT_NEAR(RatingOf(report, kEfficiencyDomain), 3, 1e-12);
  report.exercise->result.time = 80;  // the middle: 3
  EXPECT_NEAR(RatingOf(report, kEfficiencyDomain), 2.3, 1e-12);
  report.exercise->result.passed = false;
  EXPECT_NEAR(RatingOf(report, kEfficiencyDomain), 1.7, 1e-12);
  report.exercise->result.ended = false;  // not known yet
  EXPECT_NEAR(RatingOf(report, kEfficiencyDomain), 2, 1e-12);
}

TEST(Goals, TheWorstFigureDecidesTissueHandling) {
  const auto changed = [](const auto& change) {
    SessionReport report = BestSession();
    change(report);
    return RatingOf(report, kTissueDomain);
  };
  EXPECT_NEAR(changed([](auto& r) { r.hands[1].contact.peak_force = 4.2; }), 3, 1e-12);
  EXPECT_NEAR(changed([](auto& r) { r.hands[1].contact.over_limit = 3; }), 3, 1e-12);
  EXPECT_NEAR(changed([](auto& r) { r.hands[0].contact.slips = 2; }), 3, 1e-12);
  EXPECT_NEAR(changed([](auto& r) { r.attachments[0].freed_area = 5e-5; }), 3, 1e-12);
  EXPECT_EQ(changed([](auto& r) {
              r.attachments[0].freed_area = 5e-5;
              r.attachments[0].burnt_area = 3e-5;
              r.attachments[0].cut_area = 2e-5;
            }),
            5)
      << "burnt and cut, not torn";
  EXPECT_EQ(changed([](auto& r) { r.exercise->result.errors.resize(2); }), 3) << "dropped twice";
  EXPECT_EQ(changed([](auto& r) {
              r.exercise->result.errors = {{.rule = 1}, {.rule = 1}};
            }),
            5)
      << "an early clip harms nothing";
  EXPECT_EQ(changed([](auto& r) {
              r.hands[1].contact.peak_force = 4.2;
              r.hands[1].contact.over_limit = 30;
            }),
            1);
}

TEST(Goals, TissueHandlingIsNotRatedWithoutItsForces) {
  SessionReport report = BestSession();
  report.hands[0].contact.forces_off = 0.1;
  EXPECT_EQ(RatingOf(report, kTissueDomain), -1);
  report = BestSession();
  report.health.outputs_lost = 1;
  EXPECT_EQ(RatingOf(report, kTissueDomain), -1);
  report = BestSession();
  for (HandReport& hand : report.hands) hand.contact.time = 0.4;
  EXPECT_EQ(RatingOf(report, kTissueDomain), -1);
}

// One hand holds tissue, the other moves at 20 mm/s, for one of two seconds.
TEST(Goals, AHandThatHoldsTissueWorksForTheOther) {
  MadeSession session({"grasper", "probe"});
  for (int i = 0; i < 2000; ++i) {
    session.Tick([i](HapticSample* sample) {
      const bool holds = i >= 1000;
      sample->tools[0].kind = holds ? ContactKind::kGrasp : ContactKind::kNone;
      sample->tools[0].organ = holds ? 0 : -1;
      sample->tools[1].p_tip_W.x() = 2e-5 * i;
    });
  }
  const SessionReport report = session.Finish().report;
  ASSERT_TRUE(report.work.has_value());
  EXPECT_NEAR(report.work->any_moves, 2, 3 * kMotionPeriod);
  EXPECT_NEAR(report.work->together, 1, 3 * kMotionPeriod);
  EXPECT_EQ(report.both_moving, 0);
  const auto goals = ToJson(report)["goals"];
  EXPECT_NEAR(goals["bimanual_dexterity"]["figures"]["together_share"], 0.5, 0.01);
  EXPECT_NEAR(goals["bimanual_dexterity"]["rating"], 4.2, 0.11);
  EXPECT_TRUE(goals["depth_perception"]["rating"].is_null());
  EXPECT_EQ(goals["depth_perception"]["why_not"], "fewer than 5 advances along the shaft");
}

TEST(Goals, EveryScaleIsInTheReadme) {
  const std::string readme = ReadFile(HPDM_SOURCE_DIR "/tools/report/README.md");
  for (const GoalsScale& scale : GoalsScales()) {
    EXPECT_NE(readme.find("`" + std::string(scale.key) + "`"), std::string::npos) << scale.key;
  }
}

}  // namespace
}  // namespace hpdm
