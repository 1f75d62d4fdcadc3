#include "haptics/haptic_loop.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/haptic_bench.h"

namespace hpdm {
namespace {

TEST(HapticLoop, ForceAppearsAndDisappearsWithinOneTick) {
  Bench bench;
  bench.Settle();
  EXPECT_EQ(bench.Tick().tools[0].force_W, Vector3d::Zero());
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  const ToolSample touching = bench.Tick().tools[0];
  // 1.2 N in the first tick: below the slew limit of 2 N a tick.
  EXPECT_NEAR(touching.force_W.z(), 1.2, 1e-12);
  EXPECT_NEAR(touching.depth, 0.01, 1e-14);
  EXPECT_EQ(touching.organ, 0);
  EXPECT_EQ(touching.kind, ContactKind::kPress);
  EXPECT_EQ(touching.guard_flags, kGuardOk);
  // The shaft points down, so a force up is an effort back along the insertion axis.
  EXPECT_NEAR(bench.device.written[kInsertion], -1.2, 1e-12);
  EXPECT_EQ(touching.effort, bench.device.written);
  bench.device.MoveTip({0, 0, 0.003});
  const ToolSample away = bench.Tick().tools[0];
  EXPECT_EQ(away.force_W, Vector3d::Zero());
  EXPECT_EQ(away.kind, ContactKind::kNone);
  EXPECT_EQ(bench.device.written, AxisEffort::Zero());
}

TEST(HapticLoop, EffortsDoTheWorkOfTheLoggedForce) {
  Bench bench;
  bench.Settle();
  bench.device.MoveTip({0.01, -0.013, -0.004});
  const HapticSample sample = bench.Tick();
  const ToolSample& tool = sample.tools[0];
  ASSERT_GT(tool.force_W.norm(), 0.1);
  EXPECT_EQ(tool.effort, Kinematics().Jacobian(tool.joints).transpose() * tool.force_W);
}

TEST(HapticLoop, EveryTickPublishesItsToolStateAndOneSample) {
  Bench bench;
  for (std::uint64_t tick = 0; tick < 100; ++tick) {
    bench.device.MoveTip({1e-4 * static_cast<double>(tick), 0, 0.02});
    const HapticSample sample = bench.Tick();
    EXPECT_EQ(sample.tick, tick);
    EXPECT_EQ(sample.time_ns, static_cast<Nanoseconds>(tick) * kPeriod);
    EXPECT_EQ(sample.tool_count, 1);
    EXPECT_EQ(sample.compute_ns, 0);  // nothing measured is logged in virtual time
    HapticSample second;
    EXPECT_FALSE(bench.samples.Pop(&second));
    ASSERT_TRUE(bench.tool_states.Update());
    const ToolState& state = bench.tool_states.Front();
    EXPECT_EQ(state.tick, tick);
    EXPECT_EQ(state.time_ns, sample.time_ns);
    EXPECT_EQ(state.device_time_ns, sample.device_time_ns);
    EXPECT_EQ(state.tools[0].X_WT.translation(), sample.tools[0].p_tip_W);
    EXPECT_EQ(state.tools[0].p_trocar_W, kTrocar);
  }
}

TEST(HapticLoop, ToolStatesTellWhereTheJawsClosed) {
  Bench bench;
  const auto closed_at = [&bench](const Vector3d& p_W, double jaw) {
    bench.device.MoveTip(p_W);
    bench.device.joints[kJaw] = jaw;
    bench.Tick();
    bench.tool_states.Update();
    const ToolPose& tool = bench.tool_states.Front().tools[0];
    return Vector3d((tool.X_WT * tool.X_TC).translation());
  };
  const Vector3d first(0.001, 0.002, 0.02), second(0.004, 0.002, 0.022), third(-0.003, 0.001, 0.02);
  closed_at(Vector3d(0, 0, 0.02), 1);
  EXPECT_LT((closed_at(first, 0.2) - first).norm(), 1e-12);
  EXPECT_LT((closed_at(second, 0.1) - first).norm(), 1e-12);
  EXPECT_LT((closed_at(third, 0.4) - third).norm(), 1e-12) << "open";
  EXPECT_LT((closed_at(second, 0.2) - second).norm(), 1e-12) << "closed again";
}

TEST(HapticLoop, SamplesNameTheirPatchAndItsAge) {
  Bench bench;
  HapticSample sample = bench.Tick();
  EXPECT_EQ(sample.patch_number, 0u);
  EXPECT_EQ(sample.tools[0].guard_flags, kGuardStalePatch);
  bench.PublishPatch();  // of the device time of tick 1
  bench.Tick();
  sample = bench.Tick();
  EXPECT_EQ(sample.patch_number, 1u);
  EXPECT_EQ(sample.patch_age_ns, kPeriod);
}

TEST(HapticLoop, VelocitySettlesOnTheTipsOwn) {
  Bench bench;
  const Vector3d velocity(0.05, -0.02, 0.03);
  Vector3d measured = Vector3d::Zero();
  for (int i = 0; i < 100; ++i) {
    bench.device.MoveTip(Vector3d(0, 0, 0.02) + i * 1e-3 * velocity);
    measured = bench.Tick().tools[0].v_tip_W;
  }
  // 100 ms are 19 time constants of the 30 Hz filter.
  EXPECT_LT((measured - velocity).norm(), 1e-6);
}

TEST(HapticLoop, AStoppedDeformationLoopFadesTheForceOut) {
  Bench bench;
  bench.Settle();
  bench.PublishPatch();
  bench.Tick();
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  double last = bench.Tick().tools[0].force_W.norm();
  ASSERT_NEAR(last, 1.2, 1e-12);
  for (int i = 0; i < 500; ++i) {
    const HapticSample sample = bench.Tick();
    EXPECT_LE(sample.tools[0].force_W.norm(), last);
    EXPECT_EQ(sample.tools[0].guard_flags & kGuardStalePatch,
              sample.patch_age_ns > ForceGuardOptions{}.stale_age_ns ? kGuardStalePatch : 0u);
    last = sample.tools[0].force_W.norm();
  }
  // 367 ms of decay at 50 ms.
  EXPECT_LT(last, 1e-3);
}

TEST(HapticLoop, UnusableDeviceAnswersKeepThePoseAndFadeTheForceOut) {
  Bench bench;
  bench.Settle();
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  const Vector3d p = bench.Tick().tools[0].p_tip_W;
  bench.device.joints[kYaw] = std::numeric_limits<double>::quiet_NaN();
  for (int i = 0; i < 100; ++i) {
    const ToolSample tool = bench.Tick().tools[0];
    EXPECT_EQ(tool.p_tip_W, p);
    EXPECT_FALSE(tool.device_valid);
    EXPECT_TRUE(tool.guard_flags & kGuardDeviceInvalid);
    EXPECT_TRUE(bench.device.written.allFinite());
    EXPECT_EQ(tool.v_tip_W, Vector3d::Zero());
  }
  EXPECT_LT(bench.device.written.norm(), 1.2 * std::exp(-1.9));
}

TEST(HapticLoop, EmergencyStopIsZeroInTheNextTick) {
  Bench bench;
  bench.Settle();
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  ASSERT_GT(bench.Tick().tools[0].force_W.norm(), 1);
  std::thread([&] { bench.device.EmergencyStop(); }).join();
  const ToolSample tool = bench.Tick().tools[0];
  EXPECT_EQ(tool.force_W, Vector3d::Zero());
  EXPECT_EQ(bench.device.written, AxisEffort::Zero());
  EXPECT_EQ(tool.guard_flags, kGuardDisabled);
}

TEST(HapticLoop, AFullSampleQueueIsCountedAndDoesNotStopTheLoop) {
  Bench bench;
  for (int i = 0; i < 100; ++i) bench.loop->Tick(i, i * kPeriod, {});
  EXPECT_EQ(bench.samples.Overflows(), 100u - 64u);
  ASSERT_TRUE(bench.tool_states.Update());
  EXPECT_EQ(bench.tool_states.Front().tick, 99u);
}

TEST(HapticLoop, LoggedEnergyIsTheWorkOfTheLoggedForces) {
  Bench bench;
  bench.Settle();
  ToolSample last = bench.Tick().tools[0];
  double work = last.energy;
  for (int i = 0; i < 300; ++i) {
    bench.device.MoveTip({0.01 * std::sin(0.02 * i), 0, kTipRadius - 0.01 * std::sin(0.03 * i)});
    const ToolSample tool = bench.Tick().tools[0];
    work -= last.force_W.dot(tool.p_tip_W - last.p_tip_W);
    EXPECT_NEAR(tool.energy, work, 1e-15);  // round-off
    EXPECT_EQ(tool.damping, 0);             // 120 N/m is far below the device's limit
    EXPECT_FALSE(tool.guard_flags & kGuardPassivity);
    last = tool;
  }
  EXPECT_GT(work, 1e-4);
}

TEST(HapticLoop, AContactThatGivesEnergyIsDampedAndSaysSo) {
  const auto shake = [](Bench* bench) {
    bench->Settle();
    ToolSample tool;
    // The tip oscillates by 0.2 mm about a depth of 1 mm. Holding the force generates
    // K (0.2 mm)^2 / 2 = 60 uJ per tick, of which the device takes less than 0.5 N s/m (0.2 mm)^2 /
    // 1 ms + 0.1 N 0.2 mm = 40.
    for (int i = 0; i < 40; ++i) {
      bench->device.MoveTip({0, 0, kTipRadius - 0.001 + (i % 2 == 0 ? 1 : -1) * 1e-4});
      tool = bench->Tick().tools[0];
    }
    return tool;
  };
  Bench damped, bare(false);
  damped.stiffness = bare.stiffness = 3000;
  const ToolSample on = shake(&damped), off = shake(&bare);
  EXPECT_GT(on.damping, 0);
  EXPECT_TRUE(on.guard_flags & kGuardPassivity);
  EXPECT_NE(on.force_W, on.reaction_W);
  EXPECT_EQ(off.damping, 0);
  EXPECT_FALSE(off.guard_flags & kGuardPassivity);
}

TEST(HapticLoop, LockstepRunsAreIdenticalAndNoForceStepExceedsTheSlewLimit) {
  SimulatedSession a, b;
  a.Run(0, 10'000);
  b.Run(0, 10'000);
  ASSERT_EQ(a.log.size(), 10'000u);
  const double longest = ForceGuardOptions{}.max_force_rate * 1e-3;
  int in_contact = 0;
  for (std::size_t i = 0; i < a.log.size(); ++i) {
    for (int k = 0; k < kMaxInstruments; ++k) {
      const ToolSample &from_a = a.log[i].tools[k], &from_b = b.log[i].tools[k];
      ASSERT_EQ(from_a.joints, from_b.joints);
      ASSERT_EQ(from_a.force_W, from_b.force_W);
      ASSERT_EQ(from_a.effort, from_b.effort);
      in_contact += from_a.kind != ContactKind::kNone;
      if (i > 0) {
        ASSERT_LE((from_a.force_W - a.log[i - 1].tools[k].force_W).norm(), longest * (1 + 1e-12));
      }
    }
  }
  EXPECT_GT(in_contact, 2000);
}

// Tests the first press of the palpation, at rest: hand spring and tissue share the intended depth.
TEST(HapticLoop, HandAndTissueSettleWhereTheirSpringsBalance) {
  SimulatedSession session;
  session.Run(0, 6'000);
  double deepest = 0;
  for (const HapticSample& sample : session.log) {
    deepest = std::max(deepest, sample.tools[0].depth);
  }
  // The hand means the tip's centre to go 15 mm deep, so its sphere 17.5 mm: the tissue gives
  // 300 / (300 + 120) of that. The sphere's facets, friction (0.1 N), tremor and the curvature
  // under the offset point (20 mm on R = 100 mm: 2 mm) move it.
  EXPECT_NEAR(deepest, 0.0175 * 300 / 420, 0.003);
}

// The writer gets a slot back with every patch that a tick takes, and writes into it at once. The
// thread sanitizer reports a tick that still reads it.
TEST(HapticLoop, APublisherThatNeverPausesSharesNoPatchWithATick) {
  Bench bench;
  bench.Settle();
  bench.device.MoveTip({0, 0, kTipRadius - 0.01});
  std::atomic<bool> published = false;
  std::jthread publisher([&](std::stop_token stop) {
    ToolPatch patch = PlanePatch(7, 0.03, kStiffness);
    for (std::uint64_t step = 1000; !stop.stop_requested(); ++step) {
      ContactPatch& next = bench.patches.Back();
      next.step.number = step;
      next.tool_count = 1;
      patch.organ = static_cast<int>(step % 2);
      next.tools[0].places[0] = patch;
      bench.patches.Publish();
      published = true;
    }
  });
  while (!published) std::this_thread::yield();
  std::uint64_t last = 0;
  for (int patches = 0; patches < 200;) {
    const HapticSample sample = bench.Tick();
    const ToolSample& tool = sample.tools[0];
    ASSERT_EQ(tool.kind, ContactKind::kPress);
    // The organ follows from the patch's number: a tick reads one patch, not parts of two.
    ASSERT_EQ(tool.organ, static_cast<int>(sample.patch_number % 2));
    ASSERT_NEAR(tool.depth, 0.01, 1e-14);  // rounding of the inverse kinematics
    if (sample.patch_number == last) {
      std::this_thread::yield();
    } else {
      ++patches;
    }
    last = sample.patch_number;
  }
}

// Runs on the machine's own clock: checks only that the counts are right, not the timing.
TEST(HapticLoop, RealClockRunAccountsForEveryPeriodAndMeasuresEveryTick) {
  Bench bench;
  RealLoopClock clock{SessionClock()};
  SpscQueue<HapticSample> samples(1024);
  HapticLoop loop({{&bench.device, Kinematics(), {{.tip_radius = kTipRadius}}}}, kPeriod,
                  {bench.tool_states, bench.patches, samples});
  const TickCount count = loop.RunRealClock({}, clock, 2 * kPeriod, 200);
  EXPECT_GE(clock.Now(), 201 * kPeriod);
  EXPECT_EQ(count.Periods(), 200u);
  HapticSample sample;
  std::uint64_t ticks = 0, next = 0;
  while (samples.Pop(&sample)) {
    ++ticks;
    next += sample.skipped.Total();
    EXPECT_EQ(sample.tick, next++);
    EXPECT_GT(sample.compute_ns, 0);
    EXPECT_GE(sample.wake_late_ns, 0);
    EXPECT_LT(sample.wake_late_ns, kPeriod);
  }
  EXPECT_EQ(ticks, count.ticks);
}

TEST(HapticLoop, StopRequestEndsTheRun) {
  Bench bench;
  RealLoopClock clock{SessionClock()};
  TickCount count;
  {
    std::jthread haptic(
        [&](std::stop_token stop) { count = bench.loop->RunRealClock(stop, clock, 0); });
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }  // the destructor asks for the stop and joins
  EXPECT_GT(count.Periods(), 0u);
}

}  // namespace
}  // namespace hpdm
