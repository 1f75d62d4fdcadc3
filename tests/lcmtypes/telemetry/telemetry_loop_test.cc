#include "lcmtypes/telemetry/telemetry_loop.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <thread>

#include "tests/support/read_file.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/telemetry_fixture.h"

namespace hpdm {
namespace {

TEST(TelemetryLoop, EveryTickIsInTheLogOnceInOrderAndExact) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 2500);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.ticks.size(), 2500u);
  for (std::uint64_t tick = 0; tick < 2500; ++tick) {
    const HapticSample& logged = log.ticks[tick];
    const HapticSample pushed = Sample(tick, logged.patch_number);
    ASSERT_EQ(logged.tick, tick);
    for (int i = 0; i < 2; ++i) {
      ASSERT_EQ(logged.tools[i].joints, pushed.tools[i].joints);
      ASSERT_EQ(logged.tools[i].force_W, pushed.tools[i].force_W);
    }
  }
}

TEST(TelemetryLoop, EveryStepIsInTheLogWithItsInputAndVisibleTick) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 2000);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 60u);
  ASSERT_EQ(log.organs.size(), 60u);
  for (std::size_t i = 0; i < 60; ++i) {
    const contact_t& contact = log.contacts[i];
    const auto input_tick = static_cast<std::int64_t>((1000 * i + 29) / 30);
    EXPECT_EQ(contact.step, static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(contact.input_tick, input_tick);
    const std::int64_t visible = input_tick + kPatchDelayTicks;
    EXPECT_EQ(contact.visible_tick, visible < 2000 ? visible : kNeverVisible);
    EXPECT_EQ(log.organs[i].step, contact.step);
    EXPECT_EQ(log.organs[i].value_count, 3 * kControlPoints);
    EXPECT_FLOAT_EQ(log.organs[i].displacements[0], 1e-3F * static_cast<float>(i + 1));
  }
}

TEST(TelemetryLoop, AShapeThatStaysIsSentOnceASecondAndOneThatMovesAtEveryStep) {
  const ScratchFolder folder;
  constexpr int kSteps = 120, kMoves = 90;  // of 1/30 s each
  {
    SpscQueue<HapticSample> samples(64);
    StepEdges edges;
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            TwoProbesAndALiver());
    for (int step = 0; step < kSteps; ++step) {
      SceneSnapshot& scene = edges.scenes.Back();
      scene.step.number = static_cast<std::uint64_t>(step) + 1;
      scene.step.time_ns = step * kNanosecondsPerSecond / 30;
      scene.organs[0].offset_W.x() = 1e-3 * std::max(0, step - kMoves);
      edges.scenes.Publish();
      telemetry.Drain();
    }
  }
  std::vector<std::int64_t> steps;
  for (const organ_t& organ : ReadLog(folder / "session.lcmlog").organs) {
    steps.push_back(organ.step);
  }
  std::vector<std::int64_t> expected = {1, 31, 61};
  for (int step = kMoves; step < kSteps; ++step) expected.push_back(step + 1);
  EXPECT_EQ(steps, expected);
}

// The telemetry may drain late: a disk has held it up for 900 steps at 1 kHz.
TEST(TelemetryLoop, EveryStepOfALateDrainIsLoggedWithTheTickThatFirstUsedIt) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(1024);
    StepEdges edges(1024);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            SessionInfo());
    for (std::uint64_t n = 1; n <= 900; ++n) {
      edges.Publish(n, n);
      // Every third patch is replaced before a tick looks.
      if (n % 3 != 0) samples.Push(Sample(n + 1, n, n + 1));
    }
    telemetry.Drain();
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 900u);
  EXPECT_EQ(log.organs.size(), 1u) << "shapes are the latest value only";
  for (std::int64_t n = 1; n <= 900; ++n) {
    EXPECT_EQ(log.contacts[n - 1].step, n);
    EXPECT_EQ(log.contacts[n - 1].visible_tick, n % 3 != 0 ? n + 1 : kNeverVisible);
  }
}

TEST(TelemetryLoop, ALostTickDoesNotMoveAPatchsFirstUse) {
  const ScratchFolder folder;
  {
    SpscQueue<HapticSample> samples(2);
    StepEdges edges(2);
    TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                            SessionInfo());
    edges.Publish(1, 0);
    samples.Push(Sample(0, 0));
    samples.Push(Sample(1, 0));
    samples.Push(Sample(2, 1, 2));  // lost: the queue holds two
    telemetry.Drain();
    samples.Push(Sample(3, 1, 2));
    for (std::uint64_t n = 2; n <= 4; ++n) edges.Publish(n, n);  // 4 is lost
    telemetry.Finish();
    EXPECT_EQ(telemetry.Summary().queue_overflows, 1u);
    EXPECT_EQ(telemetry.Summary().step_overflows, 1u);
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.contacts.size(), 3u);
  EXPECT_EQ(log.contacts[0].visible_tick, 2);
}

TEST(TelemetryLoop, AThinnedLogHasEveryInputAndStepAndNumbersItsOutputs) {
  const ScratchFolder folder;
  TelemetryOptions options;
  options.output_interval = 100;
  const TelemetrySummary summary = RunLockstep(folder / "session.lcmlog", options, 6000);
  const LogContents log = ReadLog(folder / "session.lcmlog");  // expects no gaps
  ASSERT_EQ(log.ticks.size(), 6000u);
  EXPECT_EQ(log.contacts.size(), 180u);
  EXPECT_EQ(log.organs.size(), 60u) << "one shape in 100 ms";
  ASSERT_EQ(log.events[1].name, kLogThinned);
  EXPECT_EQ(ThinnedInterval(log.events[1].text), 100);
  // The forces rise from tick 0 until sin(t) is 1 at tick 1571: each is a peak. Later ones are not.
  EXPECT_EQ(log.ticks[1500].tools[1].force_W, Sample(1500, 0).tools[1].force_W);
  EXPECT_EQ(log.ticks[1650].tools[1].force_W, Vector3d::Zero()) << "not in the log";
  EXPECT_EQ(log.ticks[1700].tools[1].force_W, Sample(1700, 0).tools[1].force_W);
  // The running session's own figures count every tick.
  EXPECT_EQ(summary.session.tools[1].peak_force,
            RunLockstep(folder / "whole.lcmlog", {}, 6000).session.tools[1].peak_force);
  EXPECT_EQ(summary.session.ticks, 6000u);
}

TEST(TelemetryLoop, TheLogsMeshIsTheOrgan) {
  const ScratchFolder folder;
  RunLockstep(folder / "session.lcmlog", {}, 1);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  EXPECT_GT(log.meshes.size(), 1u);
  OrganDescription organ;
  std::string error;
  ASSERT_TRUE(JoinMesh(log.meshes, &organ, &error)) << error;
  EXPECT_EQ(organ.vertices.rows(), 9000);
  EXPECT_EQ(organ.lattice->kept.size(), static_cast<std::size_t>(kControlPoints));
}

TEST(TelemetryLoop, TwoLockstepSessionsAreTheSameBytes) {
  const ScratchFolder folder;
  for (const char* name : {"a", "b"}) {
    TelemetryOptions options;
    options.timeline_path = folder / (std::string(name) + ".csv");
    RunLockstep(folder / (std::string(name) + ".lcmlog"), options, 3000);
  }
  const std::string log = ReadFile(folder / "a.lcmlog");
  EXPECT_GT(log.size(), 3000u * 600u);
  EXPECT_TRUE(log == ReadFile(folder / "b.lcmlog"));
  const std::string timeline = ReadFile(folder / "a.csv");
  EXPECT_GT(timeline.size(), 300u * 20u);
  EXPECT_TRUE(timeline == ReadFile(folder / "b.csv"));
}

TEST(TelemetryLoop, StatisticsComeOnceASessionSecond) {
  const ScratchFolder folder;
  const TelemetrySummary summary = RunLockstep(folder / "session.lcmlog", {}, 2500);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.stats.size(), 3u);
  const std::int64_t ticks[] = {1000, 1000, 500};
  const std::int64_t steps[] = {30, 30, 15};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(log.stats[i].haptic.cycles, ticks[i]);
    EXPECT_EQ(log.stats[i].deformation.cycles, steps[i]);
    EXPECT_EQ(log.stats[i].interval_ns, ticks[i] * kTickPeriod);
    EXPECT_DOUBLE_EQ(log.stats[i].haptic.rate_hz, 1000);
    EXPECT_DOUBLE_EQ(log.stats[i].deformation.rate_hz, 30);
    EXPECT_EQ(log.stats[i].latencies[stats_t::HAPTIC_WAKE_UP].max_ns, 0)
        << "nothing measured in lockstep";
  }
  EXPECT_EQ(summary.session.ticks, 2500u);
  EXPECT_EQ(summary.session.ticks_lost, 0u);
  EXPECT_EQ(summary.session.steps, 75u);
  EXPECT_EQ(summary.session.steps_lost, 0u);
  EXPECT_EQ(summary.queue_overflows, 0u);
  EXPECT_EQ(summary.log.failure, LogFailure::kNone);
  EXPECT_EQ(log.events.front().name, "session.start");
  EXPECT_EQ(log.events.front().text, "instruments: left, right");
  EXPECT_EQ(log.events.back().name, "session.end");
}

TEST(TelemetryLoop, AFullQueueIsCountedAndSaidOnce) {
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(16);
  StepEdges edges;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", {},
                          SessionInfo());
  for (std::uint64_t tick = 0; tick < 20; ++tick) samples.Push(Sample(tick, 0));
  telemetry.Drain();
  samples.Push(Sample(20, 0));
  telemetry.Finish();
  EXPECT_EQ(telemetry.Summary().queue_overflows, 4u);
  EXPECT_EQ(telemetry.Summary().session.ticks_lost, 4u) << "both ways of counting agree";
  const LogContents log = ReadLog(folder / "session.lcmlog");
  EXPECT_EQ(log.ticks.size(), 17u);
  EXPECT_EQ(std::count_if(log.events.begin(), log.events.end(),
                          [](const event_t& e) { return e.name == "telemetry.overflow"; }),
            1);
}

TEST(TelemetryLoop, ASessionContinuesWithoutItsLog) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  const TelemetrySummary summary = RunLockstep("/dev/full", {}, 1500);
  EXPECT_EQ(summary.log.failure, LogFailure::kWrite);
  EXPECT_GT(summary.log.dropped, 3000u);
  EXPECT_EQ(summary.session.ticks, 1500u);
}

TEST(TelemetryLoop, LoopEventsAreLoggedWithTheirSeverityAndCutToTheirRoom) {
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(4);
  SpscQueue<LoopEvent> events(4);
  StepEdges edges;
  TelemetryOptions options;
  options.events = {&events};
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", options,
                          SessionInfo());
  events.Push(MakeLoopEvent(EventSeverity::kWarning, "render.ended", std::string(1000, 'x')));
  telemetry.Finish();
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.events.size(), 3u) << "between the session's start and its end";
  EXPECT_EQ(log.events[1].name, "render.ended");
  EXPECT_EQ(log.events[1].severity, event_t::WARNING);
  EXPECT_EQ(log.events[1].text, std::string(255, 'x'));
}

// The thread edges as a session has them: samples and snapshots come from two threads while the
// telemetry runs on its own. Nothing is lost, and ThreadSanitizer sees every access.
TEST(TelemetryLoop, LosesNothingBetweenThreads) {
  constexpr std::uint64_t kTicks = 300;
  constexpr std::uint64_t kSteps = 10;
  constexpr std::uint64_t kFrames = 15;
  const ScratchFolder folder;
  SpscQueue<HapticSample> samples(1024);
  SpscQueue<FrameRecord> frames(1024);
  StepEdges edges;
  TelemetryOptions options;
  options.frames = &frames;
  TelemetryLoop telemetry(&samples, &edges.steps, &edges.scenes, folder / "session.lcmlog", options,
                          TwoProbesAndALiver());
  {
    std::jthread reader([&](std::stop_token stop) { telemetry.Run(stop); });
    {
      std::jthread deformation([&] {
        for (std::uint64_t n = 1; n <= kSteps; ++n) {
          edges.Publish(n, 33 * n);
          std::this_thread::sleep_for(std::chrono::milliseconds(30));
        }
      });
      std::jthread render([&] {
        for (std::uint64_t n = 1; n <= kFrames; ++n) {
          frames.Push({.time_ns = static_cast<Nanoseconds>(n) * 30 * kTickPeriod, .compute_ns = 7});
          std::this_thread::sleep_for(std::chrono::milliseconds(20));
        }
      });
      std::jthread haptic([&] {
        for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
          samples.Push(Sample(tick, 0));
          std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
      });
    }
    reader.request_stop();
  }
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.ticks.size(), kTicks);
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) EXPECT_EQ(log.ticks[tick].tick, tick);
  const TelemetrySummary summary = telemetry.Summary();
  EXPECT_EQ(summary.session.steps, kSteps);
  EXPECT_EQ(log.contacts.size(), kSteps);
  EXPECT_EQ(summary.queue_overflows, 0u);
  EXPECT_EQ(summary.session.frames, kFrames);
  std::int64_t logged_frames = 0;
  for (const stats_t& stats : log.stats) logged_frames += stats.render.cycles;
  EXPECT_EQ(logged_frames, static_cast<std::int64_t>(kFrames));
}

TEST(TelemetryLoop, TheMachinesOwnLatenessAndTheTimeItLostStandBesideTheSessions) {
  const ScratchFolder folder;
  TelemetryOptions options;
  for (int i = 1; i <= 1000; ++i) options.baseline.Add(10 * i);
  // The host takes 20 ms a second; its count starts anywhere, and once steps back.
  const Nanoseconds stolen[] = {500, 520, 540, 530, 560};
  int asked = 0;
  options.stolen_time = [&] { return stolen[asked++] * kTickPeriod; };
  const TelemetrySummary summary = RunLockstep(folder / "session.lcmlog", options, 3500);
  EXPECT_EQ(asked, 5) << "at the start, and once a second";
  EXPECT_EQ(summary.session.stolen_ns, 60 * kTickPeriod);
  EXPECT_EQ(summary.session.latencies[Latency::kBaselineWakeUp].count(), 1000u);
  const LogContents log = ReadLog(folder / "session.lcmlog");
  ASSERT_EQ(log.stats.size(), 4u);
  const std::int64_t expected[] = {20, 20, 0, 20};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(log.stats[i].stolen_ns, expected[i] * kTickPeriod) << i;
    EXPECT_EQ(log.stats[i].latencies[stats_t::BASELINE_WAKE_UP].max_ns, 10'000);
  }
  EXPECT_EQ(log.events[1].name, "realtime.baseline");
  EXPECT_NE(log.events[1].text.find("10.0 us at most"), std::string::npos) << log.events[1].text;
}

}  // namespace
}  // namespace hpdm
