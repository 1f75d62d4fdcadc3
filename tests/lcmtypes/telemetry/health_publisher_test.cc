#include "lcmtypes/telemetry/health_publisher.h"

#include <gtest/gtest.h>

#include "lcmtypes/telemetry/telemetry_loop.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kTickPeriod = 1'000'000;

SessionInfo Info() {
  SessionInfo info;
  info.instruments = {"probe"};
  return info;
}

/// A telemetry loop of one instrument without organs, drained by hand.
struct HealthBench {
  HealthBench()
      : telemetry(&samples, &steps, &scenes, folder / "session.lcmlog", Options(), Info()) {}
  TelemetryOptions Options() {
    TelemetryOptions options;
    options.haptic_period = kTickPeriod;
    options.health = &health;
    return options;
  }
  HapticSample Sample(std::uint64_t tick, double force) const {
    HapticSample sample;
    sample.tick = tick;
    sample.time_ns = static_cast<Nanoseconds>(tick) * kTickPeriod;
    sample.wake_late_ns = 20'000;
    sample.tool_count = 1;
    sample.tools[0].force_W = Vector3d(0, 0, force);
    sample.tools[0].depth = 0.004;
    sample.tools[0].organ = 0;
    sample.tools[0].device_valid = true;
    return sample;
  }

  ScratchFolder folder;
  SpscQueue<HapticSample> samples{64};
  SpscQueue<StepSample> steps{64};
  TripleBuffer<SceneSnapshot> scenes;
  TripleBuffer<SessionHealth> health;
  TelemetryLoop telemetry;
};

TEST(HealthPublisher, PublishesTheNewestForceTenTimesASecond) {
  HealthBench bench;
  int published = 0;
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    bench.samples.Push(bench.Sample(tick, tick == 500 ? 3.0 : 0.001 * static_cast<double>(tick)));
    bench.telemetry.Drain();
    if (!bench.health.Update()) continue;
    ++published;
    const SessionHealth& health = bench.health.Front();
    EXPECT_EQ(health.ticks, tick + 1);
    EXPECT_EQ(health.tool_count, 1);
    EXPECT_EQ(health.tools[0].force_W.z(), tick == 500 ? 3.0 : 0.001 * static_cast<double>(tick));
    EXPECT_EQ(health.tools[0].depth, 0.004);
    EXPECT_EQ(health.tools[0].organ, 0);
    EXPECT_EQ(health.tools[0].peak_force, tick >= 500 ? 3.0 : health.tools[0].force_W.z());
  }
  EXPECT_EQ(published, 9) << "at 0.1, 0.2, ... 0.9 s";
}

TEST(HealthPublisher, RatesAreThoseOfTheLastWholeSecond) {
  HealthBench bench;
  for (std::uint64_t tick = 0; tick < 2200; ++tick) {
    if (tick >= 1000 && tick < 1100) continue;  // a tenth of the second second is skipped
    HapticSample sample = bench.Sample(tick, 0);
    if (tick == 1100) sample.skipped.stalled = 100;
    bench.samples.Push(sample);
    if (tick % 100 == 0) {
      StepSample step;
      step.step.number = tick / 100 + 1;
      step.step.time_ns = static_cast<Nanoseconds>(tick) * kTickPeriod;
      step.step.compute_ns = 2'000'000 + static_cast<Nanoseconds>(tick);
      step.step.flags = kStepBudgetSpent;
      bench.steps.Push(step);
    }
    bench.telemetry.Drain();
    bench.health.Update();
    if (tick == 999) {
      EXPECT_EQ(bench.health.Front().haptic_hz, 0) << "no second is over";
    }
    if (tick == 1999) {
      EXPECT_EQ(bench.health.Front().haptic_hz, 1000);
    }
  }
  const SessionHealth& health = bench.health.Front();
  EXPECT_EQ(health.haptic_hz, 900);
  EXPECT_EQ(health.skipped.stalled, 100u);
  EXPECT_EQ(health.deformation_hz, 9) << "the step of the missing tick was not taken either";
  EXPECT_EQ(health.step_compute_ns, 2'002'100);
  EXPECT_EQ(health.step_flags, kStepBudgetSpent);
  // The stall's own ticks woke up to 100 ms late: one of 900 is within the last hundredth.
  EXPECT_GE(health.wake_late_p99_ns, 20'000);
  EXPECT_EQ(health.log_lost, 0u);
}

TEST(HealthPublisher, LostTicksAreCounted) {
  HealthBench bench;
  for (std::uint64_t tick = 0; tick < 200; ++tick) bench.samples.Push(bench.Sample(tick, 0));
  bench.telemetry.Drain();  // the queue holds 64
  bench.samples.Push(bench.Sample(200, 0));
  bench.telemetry.Drain();
  ASSERT_TRUE(bench.health.Update());
  EXPECT_EQ(bench.health.Front().log_lost, 136u);
}

}  // namespace
}  // namespace hpdm
