#include "engine/threads/loop_schedule.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stop_token>
#include <vector>

#include "haptics/device/hand_script.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kPeriod = 1'000'000;

// A clock that moves only in the test's hands: a sleep ends `oversleep` late, and a body takes the
// time that it gives.
class FakeClock : public LoopClock {
 public:
  Nanoseconds Now() noexcept override { return now; }
  Nanoseconds ThreadCpuTime() noexcept override { return cpu; }
  void SleepUntil(Nanoseconds time) noexcept override {
    EXPECT_GT(time, now);
    now = time + oversleep;
    oversleep = 0;
  }
  void Compute(Nanoseconds wall, Nanoseconds cpu_time) {
    now += wall;
    cpu += cpu_time;
  }

  Nanoseconds now = 0;
  Nanoseconds cpu = 0;
  Nanoseconds oversleep = 0;
};

struct Ran {
  std::uint64_t tick;
  Nanoseconds at;
  TickTiming timing;
};

TEST(LoopSchedule, AnOnTimeRunHasATickInEveryPeriod) {
  FakeClock clock;
  std::vector<Ran> ran;
  const TickCount count =
      RunOnSchedule({5 * kPeriod, kPeriod, 100}, {}, clock,
                    [&](std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing) {
                      EXPECT_EQ(scheduled, static_cast<Nanoseconds>(5 + tick) * kPeriod);
                      ran.push_back({tick, clock.now, timing});
                      clock.Compute(kPeriod / 3, kPeriod / 3);
                    });
  EXPECT_EQ(count.ticks, 100u);
  EXPECT_EQ(count.skipped.Total(), 0u);
  for (std::uint64_t i = 0; i < ran.size(); ++i) {
    EXPECT_EQ(ran[i].tick, i);
    EXPECT_EQ(ran[i].timing.wake_late_ns, 0);
  }
}

TEST(LoopSchedule, EachSkippedPeriodHasItsCause) {
  FakeClock clock;
  std::vector<Ran> ran;
  const TickCount count = RunOnSchedule(
      {0, kPeriod, 40}, {}, clock, [&](std::uint64_t tick, Nanoseconds, const TickTiming& timing) {
        ran.push_back({tick, clock.now, timing});
        switch (tick) {
          case 4:  // ends within period 5: late, not skipped
            return clock.Compute(13 * kPeriod / 10, 13 * kPeriod / 10);
          case 9:  // over at 12.5: periods 10 and 11 are gone
            return clock.Compute(35 * kPeriod / 10, 35 * kPeriod / 10);
          case 19:  // the same, without having had the core
            return clock.Compute(35 * kPeriod / 10, kPeriod / 10);
          case 29:
            clock.oversleep = 42 * kPeriod / 10;  // 30 to 33 are gone
        }
        clock.Compute(kPeriod / 10, kPeriod / 10);
      });
  EXPECT_EQ(count.ticks, 32u);
  EXPECT_EQ(count.skipped.long_compute, 2u);
  EXPECT_EQ(count.skipped.stalled, 2u);
  EXPECT_EQ(count.skipped.late_wake_up, 4u);
  EXPECT_EQ(count.Periods(), 40u);

  std::uint64_t expected = 0;
  for (const Ran& r : ran) {
    expected += r.timing.skipped.Total();
    EXPECT_EQ(r.tick, expected++);  // each sample's own skips close the gap before it
    EXPECT_EQ(r.timing.wake_late_ns, r.at - static_cast<Nanoseconds>(r.tick) * kPeriod);
    EXPECT_LT(r.timing.wake_late_ns, kPeriod);  // no tick after its period: no burst
    if (r.tick == 5) {
      EXPECT_EQ(r.timing.wake_late_ns, 3 * kPeriod / 10);
    }
    if (r.tick == 12) {
      EXPECT_EQ(r.timing.skipped.long_compute, 2u);
    }
    if (r.tick == 22) {
      EXPECT_EQ(r.timing.skipped.stalled, 2u);
    }
    if (r.tick == 34) {
      EXPECT_EQ(r.timing.skipped.late_wake_up, 4u);
    }
  }
}

TEST(LoopSchedule, TicksAndSkipsAreTheElapsedPeriodsUnderRandomTrouble) {
  HandRandom random(1);
  for (int run = 0; run < 200; ++run) {
    FakeClock clock;
    std::uint64_t last = 0;
    bool first = true;
    std::stop_source stop;
    const bool stops = run % 2 == 0;
    const std::uint64_t end = 500;
    std::uint64_t stopped_at = 0;
    const TickCount count = RunOnSchedule(
        {0, kPeriod, end}, stop.get_token(), clock,
        [&](std::uint64_t tick, Nanoseconds, const TickTiming&) {
          EXPECT_TRUE(first || tick > last);
          first = false;
          last = tick;
          if (random.Uniform(0, 1) < 0.1) {
            clock.oversleep = static_cast<Nanoseconds>(random.Uniform(0, 5e6));
          }
          const auto wall =
              static_cast<Nanoseconds>(random.Uniform(0, random.Uniform(0, 1) < 0.1 ? 8e6 : 5e5));
          clock.Compute(wall, static_cast<Nanoseconds>(random.Uniform(0, 1) * 1.0 * wall));
          if (stops && tick >= 250) {
            stop.request_stop();
            stopped_at = tick;
          }
        });
    EXPECT_EQ(count.Periods(), stops ? stopped_at + 1 : end);
  }
}

TEST(LoopSchedule, AStallThatOutlastsTheEndIsCutThere) {
  FakeClock clock;
  const TickCount count = RunOnSchedule(
      {0, kPeriod, 10}, {}, clock,
      [&](std::uint64_t, Nanoseconds, const TickTiming&) { clock.Compute(100 * kPeriod, 0); });
  EXPECT_EQ(count.ticks, 1u);
  EXPECT_EQ(count.skipped.stalled, 9u);
}

}  // namespace
}  // namespace hpdm
