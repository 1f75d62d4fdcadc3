#include "haptics/device/sim_device.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "haptics/device/simulated_hand.h"
#include "tests/support/hand_site.h"

namespace hpdm {
namespace {

ImpulseEngineKinematics Kinematics(const DeviceProfile& profile = {}) {
  return {Site().p_trocar_W, Site().p_target_W - Site().p_trocar_W, profile};
}

// A hand that stays where it starts: its first reach takes days.
HandOptions Still() {
  HandOptions options = Options(HandScript::kPalpate);
  options.speed = 1e-7;
  return options;
}

// Two devices, one pushed: the difference is the force over the hand's stiffness.
TEST(SimDevice, DisplayedForcePushesTheHandBackByForceOverStiffness) {
  DeviceProfile profile;
  profile.friction = profile.rotational_friction = 0;
  const ImpulseEngineKinematics kinematics = Kinematics(profile);
  const SimulatedHand hand(Options(HandScript::kPalpate, 1e-4), Site());
  SimDevice free(profile, kinematics, std::make_unique<SimulatedHand>(hand));
  SimDevice pushed(profile, kinematics, std::make_unique<SimulatedHand>(hand));
  pushed.Home();
  pushed.EnableForce(true);
  const Vector3d force(0.3, -0.2, 1.2);
  Vector3d shift = Vector3d::Zero();
  for (Nanoseconds t = 0; t <= kSecond; t += kTick) {
    free.Read(t);
    pushed.Read(t);
    pushed.Write(kinematics.Jacobian(pushed.joints()).transpose() * force);
    shift = kinematics.Forward(pushed.joints()).translation() -
            kinematics.Forward(free.joints()).translation();
  }
  // The hand moves at 0.1 m/s meanwhile; the forces of inertia and damping differ between the two
  // by the change of the Jacobian over the 4 mm shift: 4 mm / 100 mm.
  EXPECT_LT((shift - force / hand.stiffness()).norm(), 0.05 * force.norm() / hand.stiffness());
}

TEST(SimDevice, StiffHandIsStableAndEnergyOnlyFalls) {
  for (const double stiffness : {0.0, 300.0, 2e4}) {
    HandOptions options = Still();
    options.stiffness = stiffness;
    options.damping = 0;
    const DeviceProfile profile;
    const ImpulseEngineKinematics kinematics = Kinematics(profile);
    SimDevice device(profile, kinematics, std::make_unique<SimulatedHand>(options, Site()));
    device.Home();
    device.EnableForce(true);
    Nanoseconds t = 0;
    for (; t < 30 * kTick; t += kTick) {
      device.Read(t);
      device.Write({0.3, -0.2, 5});
    }
    device.Write(AxisEffort::Zero());
    double energy = device.Energy();
    ASSERT_GT(energy, 1e-4);
    const double first = energy;
    for (; t < kSecond; t += kTick) {
      device.Read(t);
      // The axes' inertia is constant, so the trocar's geometry can exchange but not add energy;
      // the energy that the turning of J within a sub-step adds is far below that lost to friction.
      ASSERT_LE(device.Energy(), energy * (1 + 1e-6) + 1e-12);
      energy = device.Energy();
    }
    EXPECT_LT(energy, 0.05 * first);
  }
}

TEST(SimDevice, FrictionHoldsWithoutChatterAndGivesWayBeyondItsLimit) {
  HandOptions options = Still();
  options.stiffness = options.damping = 0;
  const DeviceProfile profile;
  SimDevice device(profile, Kinematics(profile), std::make_unique<SimulatedHand>(options, Site()));
  device.Home();
  device.EnableForce(true);
  device.Read(0);
  const JointVector start = device.joints();
  const AxisEffort limit(profile.rotational_friction, profile.rotational_friction,
                         profile.friction);
  Nanoseconds t = kTick;
  for (; t < kSecond; t += kTick) {
    device.Write(0.99 * limit);
    device.Read(t);
    ASSERT_EQ(device.axis_velocity(), Vector3d::Zero());
  }
  EXPECT_EQ(device.joints(), start);
  device.Write(1.5 * limit);
  device.Read(t);
  EXPECT_GT(device.axis_velocity().minCoeff(), 0);
  // Released, it stops and stays.
  device.Write(AxisEffort::Zero());
  for (int i = 0; i < 200; ++i) device.Read(t += kTick);
  EXPECT_EQ(device.axis_velocity(), Vector3d::Zero());
}

TEST(SimDevice, StopsHoldTheWorkspaceAndEffortsSaturate) {
  HandOptions options = Still();
  options.stiffness = options.damping = 0;
  DeviceProfile profile;
  SimDevice device(profile, Kinematics(profile), std::make_unique<SimulatedHand>(options, Site()));
  device.Home();
  device.EnableForce(true);
  device.Read(0);
  device.Write({1e9, -1e9, 1e9});
  device.Read(kTick);
  // One period of the greatest effort, no more.
  EXPECT_LT(device.axis_velocity()[kInsertion], profile.max_force / profile.mass * 1.0001e-3);
  for (int i = 2; i < 1000; ++i) {
    device.Read(i * kTick);
    const DeviceLimits limits = device.limits();
    ASSERT_TRUE((device.joints().array() <= limits.max_joints.array()).all());
    ASSERT_TRUE((device.joints().array() >= limits.min_joints.array()).all());
  }
  EXPECT_EQ(device.joints()[kPitch], profile.max_angle);
  EXPECT_EQ(device.joints()[kYaw], -profile.max_angle);
  EXPECT_EQ(device.axis_velocity(), Vector3d::Zero());
}

TEST(SimDevice, NotFiniteEffortsAndLongGapsAreHarmless) {
  const DeviceProfile profile;
  SimDevice device(profile, Kinematics(profile),
                   std::make_unique<SimulatedHand>(Options(HandScript::kRandom, 1e-4), Site()));
  device.Home();
  device.EnableForce(true);
  Nanoseconds t = 0;
  for (int i = 0; i < 2000; ++i) {
    const DeviceSample sample = device.Read(t);
    EXPECT_TRUE(sample.valid);
    ASSERT_TRUE(sample.joints.allFinite());
    device.Write(AxisEffort::Constant(std::numeric_limits<double>::quiet_NaN()));
    t += i % 100 == 0 ? 2 * kSecond : kTick;
  }
  const JointVector before = device.joints();
  device.Read(t + 3600 * kSecond);
  // The hand advanced by 10 ms, not by an hour: at 0.3 m/s, 3 mm.
  EXPECT_LT(std::abs(device.joints()[kInsertion] - before[kInsertion]), 0.004);
  const JointVector held = device.joints();
  device.Read(t);  // a clock that steps back moves nothing
  EXPECT_EQ(device.joints(), held);
}

TEST(SimDevice, DisplaysForceOnlyWhenHomedEnabledAndNotStopped) {
  const DeviceProfile profile;
  SimDevice device(profile, Kinematics(profile), std::make_unique<SimulatedHand>(Still(), Site()));
  auto moves = [&, t = Nanoseconds{0}]() mutable {
    for (int i = 0; i < 300; ++i) device.Read(t += kTick);
    const JointVector before = device.joints();
    device.Write({0, 0, 5});
    for (int i = 0; i < 300; ++i) device.Read(t += kTick);
    const bool moved = (device.joints() - before).norm() > 1e-3;
    device.Write(AxisEffort::Zero());
    return moved;
  };
  device.EnableForce(true);
  EXPECT_FALSE(device.ForceOn());  // not homed
  EXPECT_FALSE(moves());
  device.Home();
  EXPECT_FALSE(device.ForceOn());  // homing enables nothing
  device.EnableForce(true);
  EXPECT_TRUE(device.ForceOn());
  EXPECT_TRUE(moves());
  device.EmergencyStop();
  EXPECT_FALSE(device.ForceOn());
  device.EnableForce(true);
  EXPECT_FALSE(device.ForceOn());  // latched
  EXPECT_FALSE(moves());
  device.Home();
  device.EnableForce(true);
  EXPECT_TRUE(moves());
}

}  // namespace
}  // namespace hpdm
