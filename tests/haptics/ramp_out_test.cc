// The end of a haptic loop: the device shows no force within 20 ms of the last tick.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <vector>

#include "haptics/haptic_loop.h"
#include "tests/support/haptic_bench.h"

namespace hpdm {
namespace {

// Records every effort and requests a stop at one of its readings.
class WatchedDevice : public FakeDevice {
 public:
  DeviceSample Read(Nanoseconds now) noexcept override {
    if (++reads == stop_at) {
      stopped_at = efforts.size();
      stop_now();
    } else if (stop_at > 0 && reads > stop_at && deeper_after_stop > 0) {
      depth_ += deeper_after_stop;
      MoveTip({0.01, -0.013, kTipRadius - 0.01 - depth_});
    }
    return FakeDevice::Read(now);
  }
  void Write(const AxisEffort& effort) noexcept override {
    FakeDevice::Write(effort);
    efforts.push_back(effort);
    times.push_back(clock->Now());
  }

  LoopClock* clock = nullptr;
  std::function<void()> stop_now = [] {};
  int stop_at = 0;  // 0: never
  int reads = 0;
  std::size_t stopped_at = 0;  // efforts written before the stop
  std::vector<AxisEffort> efforts;
  std::vector<Nanoseconds> times;
  double deeper_after_stop = 0;  // m a tick

 private:
  double depth_ = 0;
};

// A virtual clock that only sleeps advance; a test can let it oversleep once.
class SteppedClock : public LoopClock {
 public:
  Nanoseconds Now() noexcept override { return now_; }
  Nanoseconds ThreadCpuTime() noexcept override { return 0; }
  void SleepUntil(Nanoseconds time) noexcept override {
    now_ = time;
    if (time < oversleep_at || oversleep == 0) return;
    now_ += oversleep;
    oversleep = 0;
  }

  Nanoseconds oversleep_at = 0, oversleep = 0;

 private:
  Nanoseconds now_ = 0;
};

// A loop in virtual time whose tip presses with the device's largest force.
struct EndedLoop {
  explicit EndedLoop(Nanoseconds tick_period = kPeriod) : period(tick_period) {
    device.clock = &clock;
    device.stop_now = [this] { stop.request_stop(); };
    device.MoveTip({0.01, -0.013, kTipRadius - 0.01});
    device.Home();
    device.EnableForce(true);
    bench.stiffness = 2000;  // 20 N, clamped
    bench.PublishPatch();
    ForceGuardOptions guard;
    guard.stale_age_ns = 3600 * kNanosecondsPerSecond;  // nothing but the end takes the force away
    loop = std::make_unique<HapticLoop>(
        std::vector{HapticInstrument{&device, Kinematics(), {{.tip_radius = kTipRadius}}, guard}},
        period, HapticLoop::Edges{bench.tool_states, bench.patches, samples, &link});
  }

  void Run(std::uint64_t end_tick) {
    count = loop->RunRealClock(stop.get_token(), clock, 0, end_tick);
  }

  // Checks the efforts after `last`, the session's last one, until they are zero. `gently`: no step
  // exceeds the guard's slew limit.
  void ExpectForceEnds(std::size_t last, bool gently = true) const {
    ASSERT_LT(last, device.efforts.size());
    ASSERT_GT(device.efforts[last][kInsertion], -8.9);
    ASSERT_LT(device.efforts[last][kInsertion], -5);
    EXPECT_EQ(device.efforts.back(), AxisEffort::Zero());
    for (std::size_t i = last + 1; i < device.efforts.size(); ++i) {
      const AxisEffort &from = device.efforts[i - 1], &to = device.efforts[i];
      for (int axis = 0; axis < 3; ++axis) {
        EXPECT_LE(std::abs(to[axis]), std::abs(from[axis])) << i;
        EXPECT_GE(to[axis] * from[axis], 0) << i << ": no push the other way";
      }
      // The columns of J are orthogonal and at most 1 long (m for pitch and yaw), and the tip
      // stands still: an effort changes by no more than its force.
      if (!gently) continue;
      EXPECT_LE((to - from).norm(), ForceGuardOptions{}.max_force_rate * ToSeconds(period)) << i;
    }
  }
  Nanoseconds TimeToNoForce(std::size_t last) const {
    return device.times.back() - device.times[last];
  }

  Nanoseconds period;
  Bench bench;
  SteppedClock clock;
  WatchedDevice device;
  std::stop_source stop;
  SpscQueue<HapticSample> samples{16384}, link{16384};
  std::unique_ptr<HapticLoop> loop;
  TickCount count;
};

constexpr Nanoseconds kMaxTimeToNoForce = 20'000'000;

TEST(RampOut, TheForceEndsWithinTwentyMillisecondsOfTheLastTick) {
  EndedLoop ended;
  ended.Run(1000);
  EXPECT_EQ(ended.count.ticks, 1000u);
  ended.ExpectForceEnds(999);
  EXPECT_LE(ended.TimeToNoForce(999), kMaxTimeToNoForce);
}

TEST(RampOut, TheForceEndsWithinTwentyMillisecondsOfAStopAtEveryRate) {
  for (const int hz : {100, 133, 1000, 10'000}) {  // the bounds of timing.haptic_hz, and between
    SCOPED_TRACE(hz);
    EndedLoop ended(kNanosecondsPerSecond / hz);
    ended.device.stop_at = hz;
    ended.Run(std::numeric_limits<std::uint64_t>::max());
    EXPECT_EQ(ended.count.ticks, static_cast<std::uint64_t>(hz)) << "that of the stop is the last";
    ended.ExpectForceEnds(ended.device.stopped_at);
    EXPECT_LE(ended.TimeToNoForce(ended.device.stopped_at), kMaxTimeToNoForce);
  }
}

TEST(RampOut, AnOversleptRampOutLeavesNoForce) {
  for (const Nanoseconds oversleep : {5 * kPeriod, 400 * kPeriod}) {
    EndedLoop ended;
    ended.clock.oversleep_at = 1004 * kPeriod;
    ended.clock.oversleep = oversleep;
    ended.Run(1000);
    ended.ExpectForceEnds(999, false);
    EXPECT_LE(ended.TimeToNoForce(999), std::max(kMaxTimeToNoForce, 5 * kPeriod + oversleep));
  }
}

TEST(RampOut, TheDevicesLinkGetsTheRampOutAndTheLogDoesNot) {
  EndedLoop ended;
  ended.Run(1000);
  HapticSample sample;
  for (std::uint64_t tick = 0; tick < 1000; ++tick) {
    ASSERT_TRUE(ended.samples.Pop(&sample));
    EXPECT_EQ(sample.tick, tick);
  }
  EXPECT_FALSE(ended.samples.Pop(&sample)) << "the log ends with the last tick";
  ASSERT_TRUE(ended.bench.tool_states.Update());
  EXPECT_EQ(ended.bench.tool_states.Front().tick, 999u) << "no step takes a later one";
  std::size_t linked = 0;
  for (; ended.link.Pop(&sample); ++linked) {
    EXPECT_EQ(sample.tick, linked);
    EXPECT_EQ(sample.tools[0].effort, ended.device.efforts[linked]);
  }
  EXPECT_EQ(linked, 1000 + ended.loop->RampOutTicks());
  EXPECT_EQ(sample.tools[0].effort, AxisEffort::Zero());
}

TEST(RampOut, ADeeperPressDoesNotRaiseTheForce) {
  EndedLoop ended;
  // After the last tick the hand presses 1 mm deeper a tick.
  ended.device.stop_at = 1000;
  ended.device.deeper_after_stop = 0.001;
  ended.Run(std::numeric_limits<std::uint64_t>::max());
  ended.ExpectForceEnds(ended.device.stopped_at);
}

TEST(RampOut, AnEmergencyStopEndsTheForceAtOnce) {
  EndedLoop ended;
  ended.device.stop_at = 1000;
  ended.device.stop_now = [&ended] {
    ended.loop->EmergencyStop();
    ended.stop.request_stop();
  };
  ended.Run(std::numeric_limits<std::uint64_t>::max());
  ASSERT_EQ(ended.device.stopped_at, 999u);
  for (std::size_t i = 999; i < ended.device.efforts.size(); ++i) {
    EXPECT_EQ(ended.device.efforts[i], AxisEffort::Zero());
  }
}

}  // namespace
}  // namespace hpdm
