// What a broken device may do, through the haptic loop: the force stays finite, within the device's
// limit and within the slew limit, and a device that is well again feels what it felt before.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptics/external_device.h"
#include "tests/haptic_bench.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMs = 1'000'000;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// Answers what the test says, checked by nobody.
class RawDevice : public FakeDevice {
 public:
  DeviceSample Read(Nanoseconds now) noexcept override {
    if (!frozen) sample.time_ns = now;
    return sample;
  }

  DeviceSample sample{.joints = JointVector::Zero(), .valid = true};
  bool frozen = false;
};

/// A loop over a plane at z = 0 with 120 N/m, in virtual time. Every tick is checked for what holds
/// under any fault.
class FaultBench {
 public:
  explicit FaultBench(Device* device)
      : loop({{device, Kinematics(), kTipRadius, {}}}, kMs, {tool_states, patches, samples}) {
    device->Home();
    device->EnableForce(true);
  }

  ToolSample Tick() {
    if (tick % 33 == 0) {
      ContactPatch& patch = patches.Back();
      patch = {};
      patch.step.number = tick / 33 + 1;
      patch.step.device_time_ns = Now();
      patch.tool_count = 1;
      patch.tools[0] = PlanePatch(7, 0.03, 120);
      patches.Publish();
    }
    loop.Tick(tick, Now(), {});
    ++tick;
    HapticSample sample;
    EXPECT_TRUE(samples.Pop(&sample));
    const ToolSample& tool = sample.tools[0];
    const ForceGuardOptions guard;
    EXPECT_TRUE(tool.force_W.allFinite() && tool.effort.allFinite() && tool.p_tip_W.allFinite() &&
                tool.v_tip_W.allFinite());
    // 1e-12: roundings of the vectors' lengths.
    EXPECT_LE(tool.force_W.norm(), guard.max_force * (1 + 1e-12));
    EXPECT_LE((tool.force_W - last_force).norm(), guard.max_force_rate * 1e-3 * (1 + 1e-12));
    last_force = tool.force_W;
    return tool;
  }
  ToolSample Ticks(int count) {
    ToolSample tool;
    for (int i = 0; i < count; ++i) tool = Tick();
    return tool;
  }
  Nanoseconds Now() const { return static_cast<Nanoseconds>(tick) * kMs; }

  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples{64};
  HapticLoop loop;
  std::uint64_t tick = 0;
  Vector3d last_force = Vector3d::Zero();
};

JointVector At(double x, double z) { return Kinematics().Inverse({x, 0, z}, 0, 1).joints; }

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
  // Through the tissue, past the device's own workspace; to the other side of the trocar; sideways.
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

/// An external device with readings as a link would put them.
struct External {
  void Push(double x, double z, Nanoseconds time) {
    readings->Back() = {.sequence = ++sequence, .time_ns = time, .joints = At(x, z), .valid = true};
    readings->Publish();
  }
  ExternalDevice device{LimitsOf({})};
  TripleBuffer<DeviceSample>* readings = &device.readings();
  std::uint64_t sequence = 0;
};

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
