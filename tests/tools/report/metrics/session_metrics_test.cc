// Figures of sessions whose answers are known in closed form.

#include "tools/report/metrics/session_metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/made_session.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/metrics/verdicts.h"

namespace hpdm {
namespace {

TEST(SessionMetrics, SumForcesByOrgan) {
  MadeSession session;
  session.Press(100, 0, -1);
  session.Press(200, 2, 0);
  session.Press(20, 0, -1);  // too short a leave to be one
  session.Press(100, 4, 0);
  session.Press(100, 0, -1);
  session.Press(300, 1, 1);
  session.Press(100, 5, 1);
  const SessionReading reading = session.Finish();
  const SessionReport& report = reading.report;
  ASSERT_EQ(report.hands.size(), 1u);
  EXPECT_EQ(report.hands[0].name, "probe");
  ASSERT_EQ(report.organs, (std::vector<std::string>{"liver", "gallbladder"}));
  EXPECT_EQ(reading.series.organs.size(), 2u);

  constexpr double kRounding = 1e-9;  // round-off of sums of a thousand terms
  const ContactMetrics& all = report.hands[0].contact;
  EXPECT_NEAR(all.time, 0.7, kRounding);
  EXPECT_EQ(all.count, 2u);
  EXPECT_EQ(all.peak_force, 5);
  EXPECT_NEAR(all.impulse, 0.4 + 0.4 + 0.3 + 0.5, kRounding);
  EXPECT_NEAR(all.mean_force, 1.6 / 0.7, kRounding);
  EXPECT_NEAR(all.over_limit, 0.2, kRounding);
  EXPECT_EQ(all.over_limit_count, 2u);
  EXPECT_EQ(all.deepest_press, 0.005);

  const ContactMetrics &liver = report.hands[0].by_organ[0], &bladder = report.hands[0].by_organ[1];
  EXPECT_NEAR(liver.time, 0.3, kRounding);
  EXPECT_EQ(liver.count, 1u);
  EXPECT_EQ(liver.peak_force, 4);
  EXPECT_EQ(liver.over_limit_count, 1u);
  EXPECT_NEAR(bladder.time, 0.4, kRounding);
  EXPECT_NEAR(bladder.mean_force, 2, kRounding);
  EXPECT_TRUE(report.health.Sound());
  EXPECT_NEAR(report.duration, 0.92, kRounding);
}

// The same slips are counted by the log's events, by the session's own statistics and by the report.
TEST(SessionMetrics, SlipsAreCountedByHandAndOrganAsOftenAsTheyAreEvents) {
  MadeSession session({"grasper", "probe"});
  const auto slip = [&](int ticks, double from, double step, int organ) {
    for (int i = 0; i < ticks; ++i) {
      session.Tick([&](HapticSample* sample) {
        ToolSample& tool = sample->tools[0];
        tool.kind = organ < 0 ? ContactKind::kNone : ContactKind::kGrasp;
        tool.organ = organ;
        tool.force_W = {0, 0, organ < 0 ? 0.0 : 1.0};
        tool.slip = from + step * i;
      });
    }
  };
  slip(100, 0, 0, 0);
  slip(100, 1e-6, 1e-6, 0);
  slip(400, 1e-4, 0, 0);  // held again
  slip(50, 1.1e-4, 1e-6, 0);
  slip(400, 0, 0, -1);  // let go
  slip(100, 1e-6, 1e-6, 1);
  int events = 0;
  const SessionReport report = session.Finish().report;
  session.Read([&events](LogEvent* event) {
    event_t message;
    if (event->channel == kEventChannel && DecodeMessage(event->data, &message)) {
      events += message.name == "grasp.slipped";
    }
    return true;
  });
  EXPECT_EQ(events, 3);
  ASSERT_EQ(report.hands.size(), 2u);
  EXPECT_EQ(report.hands[0].contact.slips, 3u);
  EXPECT_EQ(report.hands[0].by_organ[0].slips, 2u);
  EXPECT_EQ(report.hands[0].by_organ[1].slips, 1u);
  EXPECT_EQ(report.hands[1].contact.slips, 0u);
  EXPECT_EQ(ToJson(report)["hands"][0]["slips"], 3);
}

TEST(SessionMetrics, TheForceLimitIsTheSessions) {
  MadeSession session;
  session.Press(100, 2, 0);
  const SessionReport report = session.Finish(1.5).report;
  EXPECT_EQ(report.force_limit, 1.5);
  EXPECT_NEAR(report.hands[0].contact.over_limit, 0.1, 1e-9);
}

TEST(SessionMetrics, APressDeeperThanTheLimitIsJudgedThoughItsForceIsSmall) {
  MadeSession session;
  session.Press(100, 2, 0);  // 2 mm
  session.Press(50, 0, -1);
  session.Press(200, 2.5, 1);  // 2.5 mm
  const SessionReport report = session.Finish(3, 0.0015).report;
  EXPECT_EQ(report.depth_limit, 0.0015);
  const ContactMetrics& all = report.hands[0].contact;
  EXPECT_NEAR(all.over_depth, 0.3, 1e-9);
  EXPECT_EQ(all.over_depth_count, 2u);
  EXPECT_NEAR(report.hands[0].by_organ[1].over_depth, 0.2, 1e-9);
  const std::vector<Verdict> verdicts = Verdicts(report);
  EXPECT_EQ(verdicts[0].kind, Verdict::kGood) << verdicts[0].text;
  EXPECT_EQ(verdicts[1].kind, Verdict::kBad);
  EXPECT_EQ(verdicts[1].text,
            "probe: deeper than the depth limit of 1.5 mm 2 times, 0.30 s in all (deepest 2.5 mm)");
}

TEST(SessionMetrics, ADepthIsWithinTheLimitOnlyIfNoTickIsMissing) {
  MadeSession session;
  session.Press(100, 2, 0);
  SessionReport report = session.Finish().report;
  EXPECT_EQ(Verdicts(report)[1].text,
            "probe: stayed within the depth limit of 20 mm (deepest 2.0 mm)");
  report.health.ticks_lost = 1;
  EXPECT_EQ(Verdicts(report)[1].kind, Verdict::kOpen);
}

TEST(SessionMetrics, APauseCountsForNothing) {
  MadeSession session;
  session.Press(500, 1, 0);
  for (int i = 0; i < 1000; ++i) {
    session.Tick([](HapticSample* sample) {
      sample->paused = true;
      sample->tools[0].p_tip_W.x() = 1e-4 * static_cast<double>(sample->tick);
      sample->tools[0].force_W = {9, 0, 0};
      sample->tools[0].kind = ContactKind::kPress;
      sample->tools[0].organ = 0;
    });
  }
  session.Press(500, 1, 0);
  const SessionReading reading = session.Finish();
  EXPECT_NEAR(reading.report.paused, 1, 1e-9);
  EXPECT_NEAR(reading.report.active, 1, 1e-9);
  ASSERT_EQ(reading.series.pauses.size(), 1u);
  EXPECT_NEAR(reading.series.pauses[0].first, 0.5, 1e-9);
  EXPECT_NEAR(reading.series.pauses[0].second, 1.5, 1e-9);
  const HandReport& hand = reading.report.hands[0];
  EXPECT_NEAR(hand.contact.time, 1, 1e-9);
  EXPECT_EQ(hand.contact.count, 1u);  // it is not seen to end
  EXPECT_EQ(hand.contact.peak_force, 1);
  EXPECT_EQ(hand.motion.path_length, 0);
  EXPECT_NEAR(hand.motion.time, 1, 3 * kMotionPeriod);  // the segments' last samples are not whole
}

TEST(SessionMetrics, SkippedTicksHoldTheForceAndLostOnesSayNothing) {
  MadeSession session;
  session.Press(100, 2, 0);
  session.Skip(50);
  session.Tick([](HapticSample* sample) { sample->skipped.stalled = 50; });
  session.Press(99, 0, -1);
  session.Skip(200);
  session.Press(100, 0, -1);
  const SessionReading reading = session.Finish();
  const SessionReport& report = reading.report;
  EXPECT_NEAR(report.hands[0].contact.time, 0.15, 1e-9);
  EXPECT_EQ(reading.series.hands[0].peaks[25].force, 2);  // at 0.125 s, amid the skipped
  EXPECT_EQ(reading.series.hands[0].peaks[60].force, 0);  // at 0.3 s, amid the lost
  EXPECT_EQ(report.skipped.stalled, 50u);
  EXPECT_EQ(report.health.ticks_lost, 200u);
  EXPECT_NEAR(report.duration, 0.55, 1e-9);
  EXPECT_NEAR(report.active, 0.35, 1e-9);
  EXPECT_FALSE(report.health.Sound());
}

TEST(SessionMetrics, AContactOverLostTicksIsOne) {
  MadeSession session;
  session.Press(100, 2, 0);
  session.Skip(500);
  session.Press(100, 2, 0);
  const HandReport hand = session.Finish().report.hands[0];
  EXPECT_EQ(hand.contact.count, 1u);
  EXPECT_EQ(hand.by_organ[0].count, 1u);
}

TEST(SessionMetrics, ALongStallCostsNoTickBehindIt) {
  MadeSession session;
  session.Press(300, 1, 0);
  constexpr int kStall = 100'000;  // far more periods than the log has bytes / 50
  session.Skip(kStall);
  session.Tick([](HapticSample* sample) { sample->skipped.stalled = kStall; });
  session.Press(299, 2, 0);
  const SessionReport report = session.Finish().report;
  EXPECT_EQ(report.ticks, 600u);
  EXPECT_EQ(report.hands[0].contact.peak_force, 2);
  EXPECT_TRUE(report.health.Sound());
  EXPECT_NEAR(report.duration, 100.6, 1e-9);
}

TEST(SessionMetrics, AFlippedBitOfATicksNumberCostsThatTickAlone) {
  MadeSession session;
  session.Press(100, 1, 0);
  session.Press(100, 2, 0);
  session.Finish();
  for (const std::int64_t damaged : {0, 1, 50, 199}) {
    for (const int bit : {0, 3, 10, 40, 61}) {
      const SessionReading reading = session.Read([&](LogEvent* event) {
        tool_t tool;
        if (event->channel != kToolChannel || !DecodeMessage(event->data, &tool)) return true;
        if (tool.tick != damaged) return true;
        tool.tick ^= std::int64_t{1} << bit;
        EncodeMessage(tool, &event->data);
        return true;
      });
      const SessionReport& report = reading.report;
      EXPECT_GE(report.ticks, 199u) << damaged << " bit " << bit;
      EXPECT_NEAR(report.duration, 0.2, 0.0011) << damaged << " bit " << bit;  // a tick
      EXPECT_LE(report.health.ticks_lost, 1u);
      EXPECT_EQ(report.hands[0].contact.peak_force, 2);
      EXPECT_FALSE(report.health.Sound());
    }
  }
}

TEST(SessionMetrics, ALogWithoutForcesGivesNoVerdict) {
  MadeSession session;
  session.Press(100, 1, 0);
  EXPECT_EQ(Verdicts(session.Finish().report)[0].kind, Verdict::kGood);
  const SessionReport report =
      session.Read([](LogEvent* event) { return event->channel != kForceChannel; }).report;
  EXPECT_EQ(report.health.outputs_lost, 100u);
  EXPECT_FALSE(report.health.Sound());
  EXPECT_EQ(Verdicts(report)[0].kind, Verdict::kOpen);
}

// Half a sine of 5 N from tick 107 to 506, then a shorter and weaker one.
TEST(SessionMetrics, AThinnedLogHasExactContactsAndPeaks) {
  for (const int interval : {1, 10, 100}) {
    TelemetryOptions options;
    options.output_interval = interval;
    MadeSession session({"probe"}, options);
    session.Press(107, 0, -1);
    for (int i = 0; i < 400; ++i) session.Press(1, 5 * std::sin(M_PI * i / 400), 0);
    session.Press(101, 0, -1);
    for (int i = 0; i < 33; ++i) session.Press(1, 3 * std::sin(M_PI * i / 32), 1);
    session.Press(59, 0, -1);
    const SessionReport report = session.Finish().report;
    EXPECT_EQ(report.output_interval, interval);
    EXPECT_TRUE(report.health.Sound()) << interval;
    EXPECT_EQ(report.ticks, 700u);
    const HandReport& hand = report.hands[0];
    EXPECT_NEAR(hand.contact.time, 0.433, 1e-9) << interval;
    EXPECT_EQ(hand.contact.count, 2u) << interval;
    EXPECT_EQ(hand.contact.peak_force, 5) << interval;
    EXPECT_EQ(hand.contact.deepest_press, 0.005) << interval;
    EXPECT_EQ(hand.by_organ[0].peak_force, 5) << interval;
    EXPECT_EQ(hand.by_organ[1].peak_force, 3) << interval;
    EXPECT_NEAR(hand.by_organ[1].time, 0.033, 1e-9) << interval;
    // Forces that rise are all new peaks. Those that fall, by 8 N, are at most an interval late.
    const double impulse = (5 * 0.4 + 3 * 0.032) * 2 / M_PI;
    EXPECT_NEAR(hand.contact.impulse, impulse, 8 * 0.001 * interval) << interval;
    EXPECT_EQ(Verdicts(report)[0].kind, Verdict::kBad) << "5 N";
  }
}

TEST(SessionMetrics, AThinnedLogThatLacksAnOutputIsNotSound) {
  TelemetryOptions options;
  options.output_interval = 10;
  MadeSession session({"probe"}, options);
  session.Press(100, 1, 0);
  EXPECT_TRUE(session.Finish().report.health.Sound());
  const SessionReport report = session
                                   .Read([](LogEvent* event) {
                                     force_t force;
                                     return event->channel != kForceChannel ||
                                            !DecodeMessage(event->data, &force) || force.tick != 50;
                                   })
                                   .report;
  EXPECT_EQ(report.health.outputs_lost, 1u);
  EXPECT_FALSE(report.health.Sound());
}

TEST(SessionMetrics, ForcesThatWereNotShownGiveNoVerdictAndDiluteNothing) {
  for (const std::uint32_t flag : {kGuardDisabled, kGuardClamped}) {
    MadeSession session;
    session.Press(100, 2, 0);
    for (int i = 0; i < 300; ++i) {
      session.Tick([&](HapticSample* sample) {
        ToolSample& tool = sample->tools[0];
        tool.guard_flags = flag;
        tool.organ = 0;
        tool.kind = ContactKind::kPress;
        if (flag == kGuardClamped) tool.force_W = {0, 0, 2};
      });
    }
    const SessionReport report = session.Finish().report;
    const ContactMetrics& contact = report.hands[0].contact;
    EXPECT_NEAR(contact.mean_force, 2, 1e-9);
    EXPECT_NEAR(flag == kGuardDisabled ? contact.forces_off : contact.clamped, 0.3, 1e-9);
    EXPECT_EQ(flag == kGuardDisabled ? contact.clamped : contact.forces_off, 0);
    EXPECT_EQ(Verdicts(report)[0].kind, Verdict::kOpen) << Verdicts(report)[0].text;
  }
}

TEST(SessionMetrics, FrictionInTheTrocarIsNoForceOfTheTissue) {
  MadeSession session;
  const auto ticks = [&](int count, double tissue, double displayed) {
    for (int i = 0; i < count; ++i) {
      session.Tick([&](HapticSample* sample) {
        ToolSample& tool = sample->tools[0];
        tool.guard_flags = kGuardTrocar;
        tool.reaction_W = {tissue, 0, 0};
        tool.force_W = {0, 0, displayed};
        tool.organ = tissue > 0 ? 0 : -1;
        tool.kind = tissue > 0 ? ContactKind::kPress : ContactKind::kNone;
      });
    }
  };
  ticks(200, 0, 5);  // free
  ticks(100, 2, 5);
  ticks(100, 9, 2.5);  // the device displays 2.5 N of 9 N
  const SessionReading reading = session.Finish();
  const HandReport& hand = reading.report.hands[0];
  for (const ContactMetrics& contact : {hand.contact, hand.by_organ[0]}) {
    EXPECT_NEAR(contact.peak_force, 2.5, 1e-12);
    EXPECT_NEAR(contact.mean_force, 2.25, 1e-9);
    EXPECT_NEAR(contact.impulse, 0.45, 1e-9);
    EXPECT_EQ(contact.over_limit_count, 0u);
  }
  for (const auto& peak : reading.series.hands[0].peaks) EXPECT_LE(peak.force, 2.5F);
  EXPECT_EQ(Verdicts(reading.report)[0].kind, Verdict::kGood);
}

TEST(SessionMetrics, ALostDeviceNeitherMovesNorRests) {
  MadeSession session({"probe", "grasper"});
  for (int i = 0; i < 3000; ++i) {
    session.Tick([i](HapticSample* sample) {
      // Both move; the first's device is lost for a second and comes back elsewhere.
      const bool lost = i >= 1000 && i < 2000;
      sample->tools[0].p_tip_W.x() = 2e-5 * (lost ? 1000 : i);
      sample->tools[0].device_valid = !lost;
      sample->tools[1].p_tip_W.x() = 2e-5 * i;
    });
  }
  const SessionReport report = session.Finish().report;
  const HandReport& hand = report.hands[0];
  EXPECT_NEAR(hand.device_lost, 1, 1e-9);
  EXPECT_NEAR(hand.motion.time, 2, 3 * kMotionPeriod);
  EXPECT_NEAR(hand.motion.path_length, 0.04, 0.02 * 0.04);  // four ends, not the 20 mm between
  EXPECT_EQ(hand.motion.idle, 0);
  EXPECT_NEAR(report.both_moving.value(), 2, 4 * kMotionPeriod);  // by time, not by segment
}

TEST(SessionMetrics, RepeatedMeshesAreOneAndAMissingPartIsReported) {
  MadeSession session;
  session.Press(100, 1, 0);
  session.Finish();
  {
    std::vector<LogEvent> meshes;
    LogReader reader(session.log());
    for (LogEvent event; reader.Next(&event);) {
      if (event.channel == kMeshChannel) meshes.push_back(event);
    }
    SessionLog more(session.log() + ".repeated", 0);
    for (int i = 0; i < 3; ++i) {
      for (const LogEvent& mesh : meshes) more.Append(kMeshChannel, mesh.time_us, mesh.data);
    }
    LogReader again(session.log());
    for (LogEvent event; again.Next(&event);) {
      more.Append(event.channel.c_str(), event.time_us, event.data);
    }
  }
  const SessionReading repeated = ReadSession(session.log() + ".repeated");
  EXPECT_EQ(repeated.series.organs.size(), 2u);
  EXPECT_TRUE(repeated.series.organs_missing.empty());

  const SessionReading torn = session.Read([](LogEvent* event) {
    mesh_t part;
    if (event->channel == kMeshChannel && DecodeMessage(event->data, &part) && part.organ == 1) {
      part.part_count = 2;
      EncodeMessage(part, &event->data);
    }
    return true;
  });
  EXPECT_EQ(torn.series.organs.size(), 1u);
  EXPECT_EQ(torn.series.organs_missing,
            std::vector<std::string>{"gallbladder: not drawn, parts of its mesh are missing"});
}

TEST(SessionMetrics, ATornLogGivesWhatIsIntact) {
  MadeSession session;
  session.Press(1000, 2, 0);
  session.Finish();
  std::filesystem::resize_file(session.log(), std::filesystem::file_size(session.log()) * 3 / 4);
  const SessionReport report = ReadSession(session.log()).report;
  EXPECT_FALSE(report.health.Sound());
  EXPECT_FALSE(report.health.closed);
  EXPECT_GT(report.health.torn_bytes, 0u);
  EXPECT_FALSE(report.health.Faults().empty());
  EXPECT_GT(report.duration, 0.6);
  EXPECT_EQ(report.hands[0].contact.peak_force, 2);
}

TEST(SessionMetrics, ALogWithoutTicksIsRefusedInOneLine) {
  MadeSession session;
  try {
    session.Finish();
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("no session data"), std::string::npos);
  }
  EXPECT_THROW(ReadSession("/nonexistent.lcmlog"), InputError);
}

}  // namespace
}  // namespace hpdm
