#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>
#include <vector>

#include "engine/deformation_loop.h"
#include "engine/threads/realtime.h"
#include "tests/support/haptic_bench.h"
#include "tests/support/shapes.h"
#include "tools/shared/one_organ.h"

/// Tests the forces on the hand if a thread or the clock fails.
namespace hpdm {
namespace {

const double kMaxForceChange = ForceGuardOptions{}.max_force_rate * ToSeconds(kPeriod);  // N a tick
constexpr double kRounding = 1 + 1e-12;

std::vector<HapticSample> Drained(SpscQueue<HapticSample>* samples) {
  std::vector<HapticSample> drained;
  HapticSample sample;
  while (samples->Pop(&sample)) drained.push_back(sample);
  return drained;
}

// Checks that every period is a tick or a skip with a cause, that no tick runs outside of its
// period (so none in a burst), and that no force differs from the one before by more than the slew
// limit.
void ExpectOrderlyTicks(const std::vector<HapticSample>& ticks, const TickCount& count) {
  ASSERT_FALSE(ticks.empty());
  EXPECT_EQ(ticks.size(), count.ticks);
  SkippedTicks skipped;
  std::uint64_t next = 0;
  Vector3d last_W = Vector3d::Zero();
  for (const HapticSample& tick : ticks) {
    EXPECT_EQ(tick.tick, next + tick.skipped.Total());
    next = tick.tick + 1;
    EXPECT_GE(tick.wake_late_ns, 0);
    EXPECT_LT(tick.wake_late_ns, kPeriod);
    skipped.late_wake_up += tick.skipped.late_wake_up;
    skipped.long_compute += tick.skipped.long_compute;
    skipped.stalled += tick.skipped.stalled;
    const Vector3d& force_W = tick.tools[0].force_W;
    EXPECT_LE((force_W - last_W).norm(), kMaxForceChange * kRounding) << tick.tick;
    last_W = force_W;
  }
  // Periods after the last tick that ran are in the count only.
  EXPECT_LE(skipped.late_wake_up, count.skipped.late_wake_up);
  EXPECT_LE(skipped.long_compute, count.skipped.long_compute);
  EXPECT_LE(skipped.stalled, count.skipped.stalled);
}

TEST(LoopFaults, ADeformationLoopStoppedForHalfASecondFadesTheForceAndBringsItBackGently) {
  Bench bench;
  bench.Settle();
  bench.PublishPatch();
  bench.Tick();
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  const double before = bench.Tick().tools[0].force_W.norm();
  ASSERT_NEAR(before, 1.2, 1e-12) << "10 mm into 120 N/m";
  double last = before;
  for (int i = 0; i < 500; ++i) {
    const double force = bench.Tick().tools[0].force_W.norm();
    EXPECT_LE(force, last);
    last = force;
  }
  // The patch is stale in all but the first 133 ms of the 500 ms; the force decays with 50 ms.
  EXPECT_LT(last, before * std::exp(-(0.5 - 0.135) / 0.05));
  for (int i = 0; i < 600; ++i) {
    if (i % 33 == 0) bench.PublishPatch();
    const double force = bench.Tick().tools[0].force_W.norm();
    EXPECT_GE(force, last * (1 - 1e-12)) << "no dip on the way back";
    // The ramp of 0.5 s; the tissue is linear, so the force has no other reason to change.
    EXPECT_LE(force - last, before * 1e-3 / ForceGuardOptions{}.ramp_in * kRounding);
    last = force;
  }
  EXPECT_NEAR(last, before, 1e-12);
}

TEST(LoopFaults, ATelemetryThatStopsReadingChangesNothingThatTheHandFeels) {
  SimulatedSession read, unread;
  constexpr std::uint64_t kTicks = 2000;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    for (SimulatedSession* session : {&read, &unread}) {
      if (tick % 33 == 0) session->PublishPatch(tick);
      session->loop->Tick(tick, static_cast<Nanoseconds>(tick) * kPeriod, {});
    }
    HapticSample sample;
    ASSERT_TRUE(read.samples.Pop(&sample));
    for (int i = 0; i < kMaxInstruments; ++i) {
      // The forces move the simulated devices: equal motion, bit for bit, means equal forces.
      ASSERT_EQ(read.devices[i]->joints(), unread.devices[i]->joints()) << tick;
    }
  }
  EXPECT_EQ(read.samples.Overflows(), 0u);
  EXPECT_EQ(unread.samples.Overflows(), kTicks - 64)
      << "what does not fit into 64 slots is counted";
}

// A clock that a test can make jump, at a sleep or within a tick, and that lets the deformation
// loop's patches arrive every 33 ms of its time.
class JumpingClock : public LoopClock {
 public:
  explicit JumpingClock(Bench* bench) : bench_(bench) {}
  Nanoseconds Now() noexcept override { return now_ += 1000; }
  Nanoseconds ThreadCpuTime() noexcept override { return 0; }  // a tick takes no time to speak of
  void SleepUntil(Nanoseconds time) noexcept override {
    now_ = time;
    if (time >= jump_at && jump_at > 0) {
      now_ += jump_by;
      jump_at = 0;
      next_patch_ = now_ + 40 * kPeriod;  // the deformation loop was away as well
    }
    if (now_ < next_patch_) return;
    next_patch_ += 33 * kPeriod;
    bench_->tick = static_cast<std::uint64_t>(now_ / kPeriod);
    bench_->PublishPatch();
  }

  Nanoseconds jump_at = 0;  // 0: never
  Nanoseconds jump_by = 0;

 protected:
  Nanoseconds now_ = 0;

 private:
  Bench* bench_;
  Nanoseconds next_patch_ = 0;
};

TEST(LoopFaults, AClockThatJumpsByTwoSecondsIsSkippedCountedAndSafe) {
  constexpr Nanoseconds kJump = 2 * kNanosecondsPerSecond;
  Bench bench;
  SpscQueue<HapticSample> samples(8192);
  HapticLoop loop({{&bench.device, Kinematics(), {{.tip_radius = kTipRadius}}}}, kPeriod,
                  {bench.tool_states, bench.patches, samples});
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  JumpingClock clock(&bench);
  clock.jump_at = 1000 * kPeriod;
  clock.jump_by = kJump;
  const TickCount count = loop.RunRealClock({}, clock, 0, 4000);
  EXPECT_EQ(count.Periods(), 4000u);
  EXPECT_EQ(count.skipped.late_wake_up, 2000u);
  EXPECT_EQ(count.skipped.long_compute + count.skipped.stalled, 0u);
  const std::vector<HapticSample> ticks = Drained(&samples);
  ExpectOrderlyTicks(ticks, count);
  ASSERT_EQ(ticks[999].tick, 999u);
  ASSERT_NEAR(ticks[999].tools[0].force_W.norm(), 1.2, 1e-12);
  const HapticSample& after = ticks[1000];
  EXPECT_EQ(after.tick, 3000u);
  EXPECT_EQ(after.skipped.late_wake_up, 2000u);
  // Its patch is 2 s old, which leaves exp(-40) of the force: 5e-18 N, within one slewed tick.
  EXPECT_TRUE(after.tools[0].guard_flags & kGuardStalePatch);
  EXPECT_LT(after.tools[0].force_W.norm(), 1e-12);
  EXPECT_NEAR(ticks.back().tools[0].force_W.norm(), 1.2, 1e-12) << "back after the ramp";
}

// A device whose answer takes long once, as in a suspended or migrated machine.
class FrozenDevice : public FakeDevice {
 public:
  explicit FrozenDevice(std::function<void()> freeze) : freeze_(std::move(freeze)) {}
  DeviceSample Read(Nanoseconds now) noexcept override {
    if (++reads == 500) freeze_();
    return FakeDevice::Read(now);
  }
  int reads = 0;

 private:
  std::function<void()> freeze_;
};

TEST(LoopFaults, AJumpWithinATickIsStalledTimeAndNotOwnComputing) {
  class FreezingClock : public JumpingClock {
   public:
    using JumpingClock::JumpingClock;
    void Freeze() { now_ += 2 * kNanosecondsPerSecond; }
  };
  Bench bench;
  FreezingClock clock(&bench);
  FrozenDevice device([&clock] { clock.Freeze(); });
  device.MoveTip({0, 0, kTipRadius - 0.01});
  device.Home();
  device.EnableForce(true);
  SpscQueue<HapticSample> samples(4096);
  HapticLoop loop({{&device, Kinematics(), {{.tip_radius = kTipRadius}}}}, kPeriod,
                  {bench.tool_states, bench.patches, samples});
  const TickCount count = loop.RunRealClock({}, clock, 0, 3000);
  EXPECT_EQ(count.skipped.stalled, 1999u) << "tick 499 began 2 s before period 2499 did";
  EXPECT_EQ(count.skipped.Total(), count.skipped.stalled);
  ExpectOrderlyTicks(Drained(&samples), count);
}

// Runs the haptic and the deformation loop on threads of their own with the machine's clock. Checks
// what happens, not how fast.
class RealThreads : public testing::Test {
 protected:
  RealThreads()
      : organs_(OneOrgan(Options(), Ellipsoid(Vector3d(0.1, 0.07, 0.05), 1))),
        deformation_(organs_, {ToolOptions()}, {tool_states_, patches_, render_, telemetry_}) {
    // 8 mm below the pole (0, 0, 0.05) of the ellipsoid.
    device_.joints = kinematics_.Inverse(Vector3d(0, 0, 0.042), 0, 1).joints;
    device_.Home();
    device_.EnableForce(true);
  }

  static OrganOptions Options() {
    OrganOptions options;
    options.name = "ellipsoid";
    options.model = OrganModelType::kContinuum;  // a lattice takes 10 s to build under a sanitizer
    options.supports = {{BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.25)}, {}}};
    return options;
  }

  // Runs both for `ticks` periods; the deformation loop sleeps `stop_ms` once, at its step `at`.
  void Run(std::uint64_t ticks, std::uint64_t at, int stop_ms) {
    const SessionClock clock;
    HapticLoop haptics({{&device_, kinematics_}}, kPeriod, {tool_states_, patches_, samples_});
    std::jthread deformation_thread([&](std::stop_token stop) {
      RealLoopClock loop_clock(clock);
      RunOnSchedule({0, kNanosecondsPerSecond / 30}, stop, loop_clock,
                    [&](std::uint64_t step, Nanoseconds due, const TickTiming& timing) {
                      deformation_.Step(deformation_.NewestTools(), due, timing.wake_late_ns);
                      if (step >= at && stop_ms > 0) {
                        std::this_thread::sleep_for(std::chrono::milliseconds(stop_ms));
                        stop_ms = 0;
                      }
                    });
    });
    std::jthread haptic_thread([&](std::stop_token stop) {
      RequestRealtime({.fifo_priority = 80, .prefault_stack = true});
      RealLoopClock loop_clock(clock);
      count_ = haptics.RunRealClock(stop, loop_clock, 0, ticks);
    });
    haptic_thread.join();
    ticks_ = Drained(&samples_);
  }

  const ImpulseEngineKinematics kinematics_{Vector3d(0, 0, 0.15), -Vector3d::UnitZ(),
                                            DeviceProfile{}};
  FakeDevice device_;
  std::vector<OrganModel> organs_;
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  TripleBuffer<SceneSnapshot> render_{SizedSnapshot(organs_, 1, true)};
  TripleBuffer<SceneSnapshot> telemetry_{SizedSnapshot(organs_, 1, false)};
  DeformationLoop deformation_;
  SpscQueue<HapticSample> samples_{4096};
  TickCount count_;
  std::vector<HapticSample> ticks_;
};

TEST_F(RealThreads, ADeformationThreadStoppedForHalfASecondIsSurvived) {
  Run(1500, 15, 500);
  EXPECT_EQ(count_.Periods(), 1500u);
  ExpectOrderlyTicks(ticks_, count_);
  const Nanoseconds stale_age = ForceGuardOptions{}.stale_age_ns;
  std::uint64_t stale = 0;
  double last = 0, peak = 0;
  bool was_stale = false;
  for (const HapticSample& tick : ticks_) {
    const ToolSample& tool = tick.tools[0];
    const bool is_stale = tick.patch_number == 0 || tick.patch_age_ns > stale_age;
    EXPECT_EQ((tool.guard_flags & kGuardStalePatch) != 0, is_stale);
    if (is_stale && was_stale) {
      EXPECT_LE(tool.force_W.norm(), last * kRounding) << tick.tick;
    }
    stale += is_stale && tick.patch_number > 0;
    was_stale = is_stale;
    last = tool.force_W.norm();
    peak = std::max(peak, last);
  }
  EXPECT_GT(peak, 0) << "the tool presses";
  // The newest patch when the thread stops is as old as its step's input, so that of the 500 ms all
  // but the first 133 ms are stale; a machine that is busy may have skipped some of them.
  EXPECT_GE(stale + count_.skipped.Total(), 365u);
}

TEST_F(RealThreads, AHogOnEveryCoreCostsNoTickForOwnComputing) {
  std::atomic<bool> over = false;
  std::vector<std::jthread> hogs;
  for (unsigned i = 0; i < std::max(2u, std::thread::hardware_concurrency()); ++i) {
    hogs.emplace_back([&over] {
      while (!over.load(std::memory_order_relaxed)) {
      }
    });
  }
  Run(700, 0, 0);
  over = true;
  EXPECT_EQ(count_.Periods(), 700u);
  ExpectOrderlyTicks(ticks_, count_);
  // A tick would have to use the processor for half a period, 20 times what it takes under a
  // sanitizer; what the machine takes away counts as late wake-up or stalled.
  EXPECT_EQ(count_.skipped.long_compute, 0u);
}

}  // namespace
}  // namespace hpdm
