#include "haptics/safety/force_guard.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptics/device/hand_script.h"

namespace hpdm {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();
const double kTickSeconds = ForceGuardOptions{}.period;

ForceGuard::Input Healthy(const Vector3d& reaction) {
  ForceGuard::Input input;
  input.reaction_W = reaction;
  input.J = Vector3d(0.1, 0.1, 1).asDiagonal();
  input.elapsed = kTickSeconds;
  input.has_patch = true;
  input.patch_age_ns = 50'000'000;
  input.device_valid = true;
  input.force_on = true;
  return input;
}

// Returns a guard past its ramp-in that displays `force`.
ForceGuard Settled(const Vector3d& force) {
  ForceGuard guard{ForceGuardOptions{}};
  for (int i = 0; i < 600; ++i) guard.Filter(Healthy(force));
  return guard;
}

TEST(ForceGuard, PassesASafeForceUnchanged) {
  ForceGuard guard = Settled({0, 0, 0});
  const Vector3d force(0.5, -0.3, 1);
  const auto output = guard.Filter(Healthy(force));
  EXPECT_EQ(output.force_W, force);
  EXPECT_EQ(output.flags, kGuardOk);
}

TEST(ForceGuard, RampsInOverHalfASecond) {
  ForceGuard guard{ForceGuardOptions{}};
  double last = 0;
  for (int tick = 1; tick <= 500; ++tick) {
    const auto output = guard.Filter(Healthy({0, 0, 1}));
    // 500 steps of 1/500, each rounded.
    EXPECT_NEAR(output.force_W.z(), tick / 500.0, 1e-12);
    EXPECT_EQ(output.flags, kGuardRampIn);
    EXPECT_GT(output.force_W.z(), last);
    last = output.force_W.z();
  }
  guard.Filter(Healthy({0, 0, 1}));  // absorbs the rounding of the sum
  EXPECT_EQ(guard.Filter(Healthy({0, 0, 1})).flags, kGuardOk);
}

TEST(ForceGuard, RampInBoundsEvenAWildForce) {
  ForceGuard guard{ForceGuardOptions{}};
  for (int tick = 1; tick <= 100; ++tick) {
    const auto output = guard.Filter(Healthy({0, 0, 1e300}));
    EXPECT_LE(output.force_W.norm(), ForceGuardOptions{}.max_force * tick / 500.0 * (1 + 1e-12));
  }
}

TEST(ForceGuard, ClampsTheVectorAndKeepsItsDirection) {
  const Vector3d wild(30, -40, 0);
  ForceGuard guard = Settled(wild);
  ForceGuard::Input input = Healthy(wild);
  input.J = 0.01 * Matrix3d::Identity();  // a short lever: only the vector's length binds
  guard = ForceGuard{ForceGuardOptions{}};
  ForceGuard::Output output;
  for (int i = 0; i < 600; ++i) output = guard.Filter(input);
  EXPECT_EQ(output.flags, kGuardClamped);
  EXPECT_NEAR(output.force_W.norm(), ForceGuardOptions{}.max_force, 1e-12);
  EXPECT_NEAR(output.force_W.normalized().dot(wild.normalized()), 1, 1e-14);
}

TEST(ForceGuard, ClampsTheTorquesOfALongLeverAndKeepsTheDirection) {
  const Vector3d force(6, 0, 3);
  ForceGuard::Input input = Healthy(force);
  input.J = Vector3d(0.3, 0.3, 1).asDiagonal();  // 1.8 N m on the pitch axis
  ForceGuard guard{ForceGuardOptions{}};
  ForceGuard::Output output;
  for (int i = 0; i < 600; ++i) output = guard.Filter(input);
  EXPECT_EQ(output.flags, kGuardClamped);
  EXPECT_NEAR((input.J.transpose() * output.force_W)[kPitch], ForceGuardOptions{}.max_torque,
              1e-12);
  EXPECT_NEAR(output.force_W.normalized().dot(force.normalized()), 1, 1e-14);
}

TEST(ForceGuard, LimitsTheStepInForce) {
  ForceGuard guard = Settled({0, 0, 0});
  const double longest = ForceGuardOptions{}.max_force_rate * kTickSeconds;  // 2 N
  auto output = guard.Filter(Healthy({0, 0, 5}));
  EXPECT_EQ(output.flags, kGuardSlewed);
  EXPECT_NEAR(output.force_W.z(), longest, 1e-12);
  guard.Filter(Healthy({0, 0, 5}));
  output = guard.Filter(Healthy({0, 0, 5}));
  EXPECT_EQ(output.flags, kGuardOk);
  EXPECT_NEAR(output.force_W.z(), 5, 1e-12);
}

TEST(ForceGuard, NotFiniteForcesDecayFromTheLastSafeOne) {
  for (const double bad : {kNaN, kInfinity, -kInfinity}) {
    ForceGuard guard = Settled({0, 0, 3});
    double last = 3;
    for (int tick = 1; tick <= 300; ++tick) {
      const auto output = guard.Filter(Healthy({0, bad, 0}));
      ASSERT_TRUE(output.force_W.allFinite());
      EXPECT_EQ(output.flags, kGuardNotFinite);
      EXPECT_NEAR(output.force_W.z(), 3 * std::exp(-tick * kTickSeconds / 0.05), 1e-12);
      EXPECT_LT(output.force_W.z(), last);
      last = output.force_W.z();
    }
    // One good force later the true force is back at the remaining gain, which rises.
    const auto output = guard.Filter(Healthy({0, 0, 3}));
    EXPECT_EQ(output.flags, kGuardRampIn);
    EXPECT_GT(output.force_W.z(), last);
  }
}

TEST(ForceGuard, StalePatchDecaysOnlyBeyondItsAge) {
  ForceGuard guard = Settled({0, 0, 3});
  ForceGuard::Input input = Healthy({0, 0, 3});
  input.patch_age_ns = ForceGuardOptions{}.stale_age_ns;
  EXPECT_EQ(guard.Filter(input).flags, kGuardOk);
  input.patch_age_ns += 1;
  const auto output = guard.Filter(input);
  EXPECT_EQ(output.flags, kGuardStalePatch);
  EXPECT_NEAR(output.force_W.z(), 3 * std::exp(-kTickSeconds / 0.05), 1e-12);
  for (int i = 0; i < 1000; ++i) guard.Filter(input);
  // exp(-1 s / 50 ms) = 2e-9 of 3 N.
  EXPECT_LT(guard.Filter(input).force_W.norm(), 1e-8);
}

TEST(ForceGuard, DecayCountsTheTimeOfSkippedTicks) {
  ForceGuard guard = Settled({0, 0, 1});
  ForceGuard::Input input = Healthy({0, 0, 1});
  input.device_valid = false;
  input.elapsed = 0.04;  // 39 ticks were skipped
  const auto output = guard.Filter(input);
  EXPECT_EQ(output.flags, kGuardDeviceInvalid);
  EXPECT_NEAR(output.force_W.z(), std::exp(-0.04 / 0.05), 1e-12);
}

TEST(ForceGuard, WithoutAPatchThereIsNoAuthority) {
  ForceGuard guard{ForceGuardOptions{}};
  ForceGuard::Input input = Healthy({0, 0, 1});
  input.has_patch = false;
  for (int i = 0; i < 100; ++i) {
    const auto output = guard.Filter(input);
    EXPECT_EQ(output.force_W, Vector3d::Zero());
    EXPECT_EQ(output.flags, kGuardStalePatch);
  }
}

TEST(ForceGuard, EmergencyStopIsZeroAtOnceAndRampsInAgainAfterwards) {
  ForceGuard guard = Settled({0, 0, 8});
  ForceGuard::Input input = Healthy({0, 0, 8});
  input.force_on = false;
  const auto stopped = guard.Filter(input);
  EXPECT_EQ(stopped.force_W, Vector3d::Zero());  // 8 N in a tick: exempt from the slew limit
  EXPECT_EQ(stopped.flags, kGuardDisabled);
  const auto again = guard.Filter(Healthy({0, 0, 8}));
  EXPECT_EQ(again.flags, kGuardRampIn);
  EXPECT_NEAR(again.force_W.z(), 8.0 / 500, 1e-12);
}

TEST(ForceGuard, NeverExceedsSlewOrForceLimitWhateverComesIn) {
  HandRandom random(7);
  const ForceGuardOptions options;
  ForceGuard guard{options};
  Vector3d last = Vector3d::Zero();
  for (int i = 0; i < 200'000; ++i) {
    const double size = std::pow(10, random.Uniform(-3, 4));
    ForceGuard::Input input = Healthy(
        {random.Uniform(-size, size), random.Uniform(-size, size), random.Uniform(-size, size)});
    const double rare = random.Uniform(0, 1);
    if (rare < 0.01) input.reaction_W.x() = kNaN;
    if (rare > 0.99) input.reaction_W.y() = kInfinity;
    if (rare > 0.95) input.reaction_W *= 1e300;
    input.J = Vector3d(random.Uniform(0.02, 0.3), random.Uniform(0.02, 0.3), 1).asDiagonal();
    input.device_valid = random.Uniform(0, 1) > 0.02;
    input.patch_age_ns = random.Uniform(0, 1) > 0.02 ? 0 : 1'000'000'000;
    input.elapsed = kTickSeconds * std::floor(random.Uniform(1, 4));
    const auto output = guard.Filter(input);
    ASSERT_TRUE(output.force_W.allFinite());
    // Round-off in the last places only.
    ASSERT_LE((output.force_W - last).norm(), options.max_force_rate * kTickSeconds * (1 + 1e-12));
    ASSERT_LE(output.force_W.norm(), options.max_force * (1 + 1e-12));
    last = output.force_W;
  }
}

TEST(ForceGuard, RampsOutBySharesOfTheLastForceAndThenRampsIn) {
  const Vector3d force(0.5, -0.3, 1);
  ForceGuard guard = Settled(force);
  for (const double share : {0.75, 0.5, 0.25, 0.0}) {
    const auto output = guard.RampOut(share, true);
    EXPECT_EQ(output.force_W, share * force);
    EXPECT_EQ(output.flags, kGuardOk);
  }
  const auto output = guard.Filter(Healthy(force));
  EXPECT_EQ(output.flags, kGuardRampIn);
  EXPECT_NEAR(output.force_W.norm(), force.norm() / 500, 1e-15);  // rounding of one product
}

TEST(ForceGuard, RampsOutAtOnceWhereTheDeviceHasLetGo) {
  ForceGuard guard = Settled({0, 0, 1});
  const auto output = guard.RampOut(0.75, false);
  EXPECT_EQ(output.force_W, Vector3d::Zero());
  EXPECT_EQ(output.flags, kGuardDisabled);
  EXPECT_EQ(guard.RampOut(0.5, true).force_W, Vector3d::Zero()) << "it does not come back";
}

}  // namespace
}  // namespace hpdm
