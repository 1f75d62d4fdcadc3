#include "lcmtypes/telemetry/session_statistics.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 1'000'000;

HapticSample Tick(std::uint64_t tick, double force, double depth) {
  HapticSample sample;
  sample.tick = tick;
  sample.time_ns = static_cast<Nanoseconds>(tick) * kPeriod;
  sample.tool_count = 1;
  sample.tools[0].force_W = Vector3d(0, 0.6 * force, -0.8 * force);  // of length `force`
  sample.tools[0].depth = depth;
  sample.tools[0].kind = force > 0 ? ContactKind::kPress : ContactKind::kNone;
  return sample;
}

StepRecord Step(std::uint64_t number, Nanoseconds time) {
  StepRecord step;
  step.number = number;
  step.time_ns = time;
  step.compute_ns = 10;
  return step;
}

// Ticks 1..6, of which 4 is skipped; in contact in 2, 3 and 6 with 1, 3 and 2 N. Tick 3's force
// stands through the skipped period.
TEST(SessionStatistics, AgreesWithASeriesComputedByHand) {
  SessionStatistics statistics(kPeriod);
  statistics.Add(Tick(1, 0, 0));
  statistics.Add(Tick(2, 1, 0.002));
  statistics.Add(Tick(3, 3, 0.005));
  HapticSample late = Tick(5, 0, 0);
  late.skipped.stalled = 1;
  statistics.Add(late);
  statistics.Add(Tick(6, 2, 0.004));

  const SessionSummary summary = statistics.Summary();
  EXPECT_EQ(summary.ticks, 5u);
  EXPECT_EQ(summary.ticks_lost, 0u);
  EXPECT_EQ(summary.skipped.stalled, 1u);
  EXPECT_EQ(summary.skipped.Total(), 1u);
  ASSERT_EQ(summary.tool_count, 1);
  const ToolSummary& tool = summary.tools[0];
  // Sums of a few decimal numbers: exact to a rounding.
  EXPECT_NEAR(tool.peak_force, 3, 1e-12);
  EXPECT_NEAR(tool.deepest_press, 0.005, 1e-12);
  EXPECT_NEAR(tool.contact_time, 4e-3, 1e-12) << "ticks 2, 3, the skipped 4, and 6";
  EXPECT_NEAR(tool.mean_force, (1 + 3 + 3 + 2) / 4.0, 1e-12);
  EXPECT_NEAR(summary.haptic_hz, 800, 1e-9) << "four ticks more in 5 ms";
}

TEST(SessionStatistics, SlipsInTheJawsAreCounted) {
  SessionStatistics statistics(kPeriod);
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    HapticSample sample = Tick(tick, 1, 0);
    sample.tools[0].slip = tick < 100 ? 0 : tick < 600 ? 1e-4 : 2e-4;
    statistics.Add(sample);
  }
  EXPECT_EQ(statistics.Summary().tools[0].slips, 2);
}

TEST(SessionStatistics, FrictionInTheTrocarIsNoForceOfTheTissue) {
  SessionStatistics statistics(kPeriod);
  const auto add = [&](std::uint64_t tick, double tissue, double displayed) {
    HapticSample sample = Tick(tick, displayed, 0);
    ToolSample& tool = sample.tools[0];
    tool.reaction_W = Vector3d(tissue, 0, 0);
    tool.guard_flags = kGuardTrocar;
    tool.kind = tissue > 0 ? ContactKind::kPress : ContactKind::kNone;
    statistics.Add(sample);
  };
  add(1, 0, 5);    // free, with 5 N of friction
  add(2, 2, 4.5);  // the friction adds to the tissue's force
  add(3, 9, 3);    // the device displays 3 N of 9 N
  const ToolSummary tool = statistics.Summary().tools[0];
  EXPECT_NEAR(tool.peak_force, 3, 1e-12);
  EXPECT_NEAR(tool.mean_force, (2 + 3) / 2.0, 1e-12);
}

TEST(SessionStatistics, RatesOfTheFirstIntervalBeginWithTheFirstTick) {
  SessionStatistics statistics(kPeriod);
  for (std::uint64_t tick = 400; tick < 1000; ++tick) statistics.Add(Tick(tick, 0, 0));
  stats_t stats{};
  statistics.CloseInterval(1000 * kPeriod, &stats);
  EXPECT_EQ(stats.interval_ns, 600 * kPeriod);
  EXPECT_DOUBLE_EQ(stats.haptic.rate_hz, 1e9 / static_cast<double>(kPeriod));
}

TEST(SessionStatistics, TicksMissingWithoutACauseAreLost) {
  SessionStatistics statistics(kPeriod);
  statistics.Add(Tick(10, 0, 0));
  HapticSample sample = Tick(20, 0, 0);
  sample.skipped.late_wake_up = 4;
  statistics.Add(sample);
  EXPECT_EQ(statistics.Summary().ticks_lost, 5u) << "11..19 are nine, four of them skipped";
}

TEST(SessionStatistics, LostStepsAreCountedByTheirNumbers) {
  SessionStatistics statistics(kPeriod);
  statistics.Add(Step(2, 100'000'000));
  statistics.Add(Step(3, 150'000'000));
  statistics.Add(Step(6, 300'000'000));
  const SessionSummary summary = statistics.Summary();
  EXPECT_EQ(summary.steps, 3u);
  EXPECT_EQ(summary.steps_lost, 3u) << "1, 4 and 5";
  EXPECT_NEAR(summary.deformation_hz, 20, 1e-9) << "steps 2 to 6 ran 50 ms apart";
  EXPECT_EQ(summary.latencies[Latency::kDeformationCompute].max(), 10);
}

TEST(SessionStatistics, StepsThatDidLessAreCounted) {
  SessionStatistics statistics(1'000'000);
  StepRecord step;
  for (step.number = 1; step.number <= 10; ++step.number) {
    step.time_ns += 33'000'000;
    step.flags = step.number > 7 ? kStepShed | kStepBudgetSpent : kStepBudgetSpent;
    statistics.Add(step);
  }
  stats_t stats{};
  statistics.CloseInterval(step.time_ns, &stats);
  EXPECT_EQ(stats.steps_shed, 3);
  statistics.CloseInterval(2 * step.time_ns, &stats);
  EXPECT_EQ(stats.steps_shed, 0);
  EXPECT_EQ(statistics.Summary().steps_shed, 3u);
}

TEST(SessionStatistics, IntervalsRestartAndTheSessionContinues) {
  SessionStatistics statistics(kPeriod);
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    HapticSample sample = Tick(tick, 0, 0);
    sample.wake_late_ns = tick < 990 ? 5 : 60;
    sample.compute_ns = 7;
    sample.patch_number = tick < 100 ? 0 : 1;
    sample.patch_age_ns = 33;
    statistics.Add(sample);
  }
  for (std::uint64_t n = 1; n <= 30; ++n) statistics.Add(Step(n, 0));
  stats_t stats{};
  statistics.CloseInterval(kNanosecondsPerSecond, &stats);
  EXPECT_EQ(stats.time_ns, kNanosecondsPerSecond);
  EXPECT_EQ(stats.interval_ns, kNanosecondsPerSecond);
  EXPECT_EQ(stats.haptic.cycles, 1000);
  EXPECT_DOUBLE_EQ(stats.haptic.rate_hz, 1000);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_COMPUTE].p99_ns, 7);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].count, 1000);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].p50_ns, 5);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].p99_ns, 5) << "990 of 1000 do not exceed it";
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].p999_ns, 60);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].max_ns, 60);
  EXPECT_EQ(stats.latencies[stats_t::PATCH_AGE].count, 900) << "no age before the first patch";
  EXPECT_EQ(stats.deformation.cycles, 30);
  EXPECT_DOUBLE_EQ(stats.deformation.rate_hz, 30);
  EXPECT_TRUE(statistics.interval_empty());

  statistics.Add(Tick(1000, 0, 0));
  EXPECT_FALSE(statistics.interval_empty());
  statistics.CloseInterval(2 * kNanosecondsPerSecond, &stats);
  EXPECT_EQ(stats.haptic.cycles, 1);
  EXPECT_EQ(stats.latencies[stats_t::HAPTIC_WAKE_UP].max_ns, 0);
  EXPECT_EQ(statistics.Summary().ticks, 1001u);
  EXPECT_EQ(statistics.Summary().latencies[Latency::kHapticWakeUp].max(), 60);
}

TEST(SessionStatistics, PeriodsRunFromWakeUpToWakeUpAndNotOverWhatWasLost) {
  SessionStatistics statistics(kPeriod);
  HapticSample sample = Tick(0, 0, 0);
  statistics.Add(sample);
  sample = Tick(1, 0, 0);
  sample.wake_late_ns = 20;
  statistics.Add(sample);
  sample = Tick(4, 0, 0);  // 2 and 3 were skipped
  sample.skipped.late_wake_up = 2;
  statistics.Add(sample);
  statistics.Add(Tick(7, 0, 0));  // 5 and 6 never came
  const SessionSummary summary = statistics.Summary();
  const Histogram& period = summary.latencies[Latency::kHapticPeriod];
  EXPECT_EQ(period.count(), 2u);
  EXPECT_EQ(period.max(), 3 * kPeriod - 20);
  EXPECT_DOUBLE_EQ(period.mean(), (1 + 3) * kPeriod / 2.0) << "the 20 ns cancel";
  EXPECT_EQ(summary.latencies[Latency::kHapticWakeUp].max(), 2 * kPeriod)
      << "tick 4 ran on time, but the wake-up was meant for tick 2";
}

TEST(SessionStatistics, DeviceToForceIsTakenForEachToolWithAnAnswer) {
  SessionStatistics statistics(kPeriod);
  HapticSample sample = Tick(10, 0, 0);
  sample.tool_count = 2;
  sample.wake_late_ns = 5'000;
  sample.written_ns = 2'000;
  sample.tools[0].device_valid = true;
  sample.tools[0].device_time_ns = sample.time_ns + 4'000;
  sample.tools[1].device_valid = false;  // vanished: its age does not count as latency
  statistics.Add(sample);
  const SessionSummary summary = statistics.Summary();
  EXPECT_EQ(summary.latencies[Latency::kDeviceToForce].count(), 1u);
  EXPECT_EQ(summary.latencies[Latency::kDeviceToForce].max(), 5'000 + 2'000 - 4'000);
}

TEST(SessionStatistics, FramesAndStepsHaveTheirLatencies) {
  SessionStatistics statistics(kPeriod);
  for (std::int64_t n = 1; n <= 3; ++n) {
    StepRecord step = Step(static_cast<std::uint64_t>(n), n * 33 * kPeriod);
    step.wake_late_ns = n;
    statistics.Add(step);
    statistics.Add(FrameRecord{.time_ns = n * 40 * kPeriod,
                               .device_time_ns = n * 40 * kPeriod - 25 * kPeriod,
                               .compute_ns = 9});
  }
  const Latencies latencies = statistics.Summary().latencies;
  EXPECT_EQ(latencies[Latency::kDeformationWakeUp].max(), 3);
  EXPECT_EQ(latencies[Latency::kDeformationPeriod].count(), 2u);
  EXPECT_EQ(latencies[Latency::kDeformationPeriod].max(), 33 * kPeriod + 1);
  EXPECT_EQ(latencies[Latency::kRenderPeriod].max(), 40 * kPeriod);
  EXPECT_EQ(latencies[Latency::kDeviceToPhoton].max(), 25 * kPeriod);
  EXPECT_EQ(latencies[Latency::kRenderCompute].max(), 9);
  EXPECT_EQ(statistics.Summary().frames, 3u);
}

// Reads the statistics as a plot or a comparison of machines does.
TEST(SessionStatistics, TheBinsOfAllMessagesAddUpToTheSession) {
  Histogram baseline;
  for (int i = 0; i < 1000; ++i) baseline.Add(3000 + i);
  SessionStatistics statistics(kPeriod, baseline);
  std::map<std::pair<int, std::int64_t>, std::int64_t> bins;
  stats_t stats{};
  for (std::uint64_t tick = 0; tick < 5000; ++tick) {
    HapticSample sample = Tick(tick, 0, 0);
    sample.wake_late_ns = static_cast<Nanoseconds>(tick * tick % 70'001);
    statistics.Add(sample);
    if (tick % 1000 != 999) continue;
    statistics.AddStolen(10'000'000);
    statistics.CloseInterval(static_cast<Nanoseconds>(tick + 1) * kPeriod, &stats);
    EXPECT_EQ(stats.bin_count, static_cast<int>(stats.bins.size()));
    EXPECT_EQ(stats.stolen_ns, 10'000'000);
    EXPECT_EQ(stats.latencies[stats_t::BASELINE_WAKE_UP].count, 1000) << "in every message";
    for (const bin_t& bin : stats.bins) bins[{bin.distribution, bin.upper_ns}] += bin.count;
  }
  const SessionSummary summary = statistics.Summary();
  EXPECT_EQ(summary.stolen_ns, 50'000'000);
  std::map<std::pair<int, std::int64_t>, std::int64_t> expected;
  summary.latencies.ForEach([&](std::size_t index, const Histogram& histogram) {
    histogram.ForEachBin([&](std::int64_t upper_ns, std::uint64_t count) {
      expected[{static_cast<int>(index), upper_ns}] = static_cast<std::int64_t>(count);
    });
  });
  EXPECT_EQ(bins, expected);
}

TEST(SessionStatistics, ASessionWithoutTicksIsAllZero) {
  const SessionSummary summary = SessionStatistics(kPeriod).Summary();
  EXPECT_EQ(summary.ticks, 0u);
  EXPECT_EQ(summary.haptic_hz, 0);
  EXPECT_EQ(summary.deformation_hz, 0);
  EXPECT_EQ(summary.tool_count, 0);
}

}  // namespace
}  // namespace hpdm
