// Tests faults of a device through the haptic loop: the force stays finite, within the device's
// limit and within the slew limit, and a device that works again has the same force as before.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/fault_bench.h"

namespace hpdm {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(DeviceFaults, NotANumberInAnyAxisIsOneTickWithoutAPoseAndLittleForceLost) {
  for (int axis = 0; axis < 5; ++axis) {
    for (const double bad : {kNaN, std::numeric_limits<double>::infinity(), -1e308 * 10}) {
      RawDevice device;
      device.sample.joints = At(0, -0.005);
      FaultBench bench(&device);
      const double before = bench.Ticks(700).force_W.norm();
      EXPECT_NEAR(before, 120 * 0.0075, 1e-9);
      device.sample.joints[axis] = bad;
      const ToolSample tool = bench.Tick();
      EXPECT_FALSE(tool.device_valid);
      EXPECT_TRUE(tool.guard_flags & kGuardDeviceInvalid);
      // One tick of the guard's 50 ms decay.
      EXPECT_NEAR(tool.force_W.norm(), before * std::exp(-0.02), 1e-9);
      device.sample.joints = At(0, -0.005);
      EXPECT_NEAR(bench.Ticks(20).force_W.norm(), before, 1e-9) << "2 % of the ramp are 10 ms";
    }
  }
}

TEST(DeviceFaults, AJumpOfHalfAMetreForOneSampleMovesTheForceByTwoSlewSteps) {
  // Jumps through the tissue beyond the workspace, to the other side of the trocar, and sideways.
  const JointVector jumps[] = {(JointVector() << 0, 0, 0.6, 0, 1).finished(),
                               (JointVector() << 0, 0, -0.4, 0, 1).finished(),
                               (JointVector() << 0, 1.4, 0.5, 0, 1).finished(),
                               (JointVector() << 9, -9, 0.3, 9, 9).finished()};
  for (const JointVector& jump : jumps) {
    RawDevice device;
    device.sample.joints = At(0, -0.005);
    FaultBench bench(&device);
    const ToolSample before = bench.Ticks(700);
    device.sample.joints = jump;
    bench.Tick();
    device.sample.joints = At(0, -0.005);
    bench.Tick();
    const ToolSample after = bench.Ticks(100);
    EXPECT_EQ(after.kind, ContactKind::kPress);
    EXPECT_NEAR(after.depth, before.depth, 1e-9);
    EXPECT_LT((after.force_W - before.force_W).norm(), 1e-9) << "what the tip felt before";
    EXPECT_LT(after.v_tip_W.norm(), 1e-3) << "500 m/s through 19 time constants of the filter";
  }
}

TEST(DeviceFaults, ADeviceThatJumpsAndStaysStaysWithinTheSlewLimit) {
  RawDevice device;
  device.sample.joints = At(0, 0.02);
  FaultBench bench(&device);
  bench.Ticks(700);
  for (int i = 0; i < 200; ++i) {
    device.sample.joints = At(i % 2 == 0 ? 0.0 : 0.3, i % 3 == 0 ? -0.4 : 0.05);
    bench.Tick();
  }
  device.sample.joints = At(0, 0.02);
  EXPECT_EQ(bench.Ticks(50).force_W, Vector3d::Zero());
}

TEST(DeviceFaults, AFrozenDeviceKeepsItsForceAndLosesItsVelocity) {
  RawDevice device;
  FaultBench bench(&device);
  for (int i = 0; i < 700; ++i) {
    device.sample.joints = At(0, 0.002 - 1e-5 * i);
    bench.Tick();
  }
  device.frozen = true;  // the time stamp too
  const ToolSample at_once = bench.Tick();
  EXPECT_LT(at_once.v_tip_W.z(), -5e-3) << "within 5 ms it may be late";
  const ToolSample later = bench.Ticks(100);
  // 95 ms at the 5.3 ms of the velocity's filter.
  EXPECT_LT(later.v_tip_W.norm(), 1e-8);
  EXPECT_LT((later.force_W - at_once.force_W).norm(), 1e-12) << "the spring is still pressed";
}

TEST(DeviceFaults, AnExternalDeviceIsInvalidUntilItsFirstReading) {
  External external;
  FaultBench bench(&external.device);
  for (int i = 0; i < 100; ++i) {
    const ToolSample tool = bench.Tick();
    EXPECT_FALSE(tool.device_valid);
    EXPECT_EQ(tool.force_W, Vector3d::Zero());
  }
  external.Push(0, -0.005, bench.Now());
  EXPECT_TRUE(bench.Tick().device_valid);
}

TEST(DeviceFaults, AVanishedDeviceHoldsThenLosesItsForceAndComesBackByTheRamp) {
  External external;
  FaultBench bench(&external.device);
  for (int i = 0; i < 700; ++i) {
    external.Push(0, -0.005, bench.Now());
    bench.Tick();
  }
  const Vector3d force = bench.last_force;
  ASSERT_NEAR(force.z(), 120 * 0.0075, 1e-9);
  const Vector3d p = Kinematics().Forward(At(0, -0.005)).translation();
  for (int i = 0; i < 50; ++i) {  // the newest reading is i + 1 ms old
    const ToolSample tool = bench.Tick();
    ASSERT_TRUE(tool.device_valid) << i;
    ASSERT_EQ(tool.force_W, force);
    ASSERT_LT((tool.p_tip_W - p).norm(), 1e-15);
  }
  for (int i = 0; i < 500; ++i) {
    const ToolSample tool = bench.Tick();
    ASSERT_FALSE(tool.device_valid) << i;
    ASSERT_LT((tool.p_tip_W - p).norm(), 1e-15) << "the last pose stands";
  }
  EXPECT_LT(bench.last_force.norm(), 1e-4) << "ten time constants of 50 ms";

  // It comes back elsewhere, still pressing.
  double last = bench.last_force.z();
  for (int i = 0; i < 520; ++i) {
    external.Push(0.01, -0.005, bench.Now());
    const ToolSample tool = bench.Tick();
    EXPECT_TRUE(tool.device_valid);
    // The ramp of 0.5 s: 0.9 N come back at 1.8 mN a tick.
    EXPECT_LT(tool.force_W.norm() - last, 2e-3);
    last = tool.force_W.norm();
  }
  EXPECT_NEAR(last, 120 * 0.0075, 0.01) << "the shaft leans by 0.1 rad at 10 mm";
}

TEST(DeviceFaults, AReadingThatItsDriverCallsInvalidIsNotUsedAtAll) {
  External external;
  FaultBench bench(&external.device);
  for (int i = 0; i < 10; ++i) {
    external.Push(0, 0.01, bench.Now());
    bench.Tick();
  }
  external.readings->Back() = {.sequence = 11, .time_ns = bench.Now(), .joints = At(0, -0.05)};
  external.readings->Publish();
  const ToolSample tool = bench.Tick();
  EXPECT_FALSE(tool.device_valid);
  EXPECT_NEAR(tool.p_tip_W.z(), 0.01, 1e-12);
}

TEST(DeviceFaults, AnExternalReadingStaysInsideTheWorkspaceAndNotInTheFuture) {
  External external;
  const DeviceLimits limits = external.device.limits();
  external.readings->Back() = {.sequence = 1,
                               .time_ns = 10 * kMs,
                               .joints = (JointVector() << 1e300, -1e300, -5, 1e9, 7).finished(),
                               .valid = true};
  external.readings->Publish();
  const DeviceSample sample = external.device.Read(3 * kMs);
  EXPECT_TRUE(sample.valid);
  EXPECT_EQ(sample.time_ns, 3 * kMs);
  EXPECT_TRUE((sample.joints.array() >= limits.min_joints.array()).all());
  EXPECT_TRUE((sample.joints.array() <= limits.max_joints.array()).all());
}

}  // namespace
}  // namespace hpdm
