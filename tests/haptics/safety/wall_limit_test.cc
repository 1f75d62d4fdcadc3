#include "haptics/safety/wall_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "haptics/device/impulse_engine.h"
#include "haptics/safety/stability.h"

namespace hpdm {
namespace {

constexpr double kLimitPeriod = 1e-3;  // s

PassivityOptions LimitOptions(const DeviceProfile& profile, bool control = true) {
  PassivityOptions options;
  options.control = control;
  options.device = AxesOf(profile);
  options.period = kLimitPeriod;
  return options;
}

// The Jacobian of a tip `lever` (m) from its trocar, with the shaft along -z.
Matrix3d JacobianAt(double lever, const DeviceProfile& profile) {
  const ImpulseEngineKinematics kinematics({0, 0, lever}, -Vector3d::UnitZ(), profile);
  return kinematics.Jacobian(kinematics.Inverse(Vector3d::Zero(), 0, 1).joints);
}

Vector3d Tilted(double across) { return {0, across, std::sqrt(1 - across * across)}; }

TEST(WallLimit, FrictionOverEncoderStepBoundsTheShaftAndTheLeverByTheirOwnFigures) {
  const DeviceProfile profile;
  const WallLimits limits(LimitOptions(profile), 0, 0.02, 0.3);
  for (const double lever : {0.1, 0.17, 0.24}) {
    const Matrix3d J = JacobianAt(lever, profile);
    const double shaft = 2 * profile.friction / profile.encoder_step;
    const double turning =
        2 * profile.rotational_friction / (profile.angle_encoder_step * lever * lever);
    EXPECT_NEAR(limits.Along(J, Vector3d::UnitZ()).friction, shaft, 1e-9 * shaft);
    EXPECT_NEAR(limits.Along(J, Vector3d::UnitY()).friction, turning, 1e-9 * turning);
    EXPECT_NEAR(limits.InEveryDirection(J).friction, std::min(shaft, turning), 1e-9 * turning);
    // Obliquely: friction and step of the motion along the normal.
    const double across = 0.6, along = 0.8;
    const double friction = along * profile.friction + across * profile.rotational_friction / lever;
    const double step = along * profile.encoder_step + across * lever * profile.angle_encoder_step;
    EXPECT_NEAR(limits.Along(J, Tilted(across)).friction, 2 * friction / step, 1e-6 * shaft);
  }
}

TEST(WallLimit, NoDirectionHasLessThanTheLimitInEveryDirection) {
  for (const double delay : {0.0, 0.002}) {
    const DeviceProfile profile;
    const WallLimits limits(LimitOptions(profile), delay, 0.02, 0.3);
    for (const double lever : {0.05, 0.13, 0.24}) {
      const Matrix3d J = JacobianAt(lever, profile);
      const WallLimit least = limits.InEveryDirection(J);
      for (double across = 0; across <= 1; across += 0.05) {
        for (const double turn : {0.0, 0.5, 1.5}) {
          const Vector3d n_W =
              Eigen::AngleAxisd(turn, Vector3d::UnitZ()) * Tilted(std::min(across, 1.0));
          const WallLimit limit = limits.Along(J, n_W);
          EXPECT_GE(limit.stability, least.stability * (1 - 1e-9));
          EXPECT_GE(limit.friction, least.friction * (1 - 1e-9));
        }
      }
    }
  }
}

TEST(WallLimit, AlongAnAxisTheStabilityIsThatOfItsOwnLoop) {
  // Independent of the roots: the sampled loop itself, stable just below the limit and unstable
  // just above it, with the damper that the controller has at this lever.
  const DeviceProfile profile;
  const double lever = 0.02 + 0.28 * 8 / 16;  // a lever of the table
  for (const double delay : {0.0, 0.001}) {
    const PassivityOptions options = LimitOptions(profile);
    const WallLimits limits(options, delay, 0.02, 0.3);
    const Matrix3d J = JacobianAt(lever, profile);
    const double K = limits.Along(J, Vector3d::UnitY()).stability * lever * lever;
    const double D = FullDamping(options, kPitch, lever, 3e-3, delay);
    const HeldForceStep step =
        ExactStep({profile.rotational_inertia, profile.rotational_damping}, kLimitPeriod);
    const auto grows = [&](double stiffness) {
      Eigen::Vector2d state(1e-6, 0);
      double past[3] = {1e-6, 1e-6, 1e-6}, late = 0, first = 0, last = 0;
      for (int k = 0; k < 40000; ++k) {
        const double now = -stiffness * state[0] - D * (state[0] - past[2]) / 3e-3;
        const double force = delay > 0 ? late : now;
        late = now;
        past[2] = past[1];
        past[1] = past[0];
        past[0] = state[0];
        state = step.transition * state + step.input * force;
        if (k < 1000) first = std::max(first, std::abs(state[0]));
        if (k >= 39000) last = std::max(last, std::abs(state[0]));
        if (!(std::abs(state[0]) < 1)) return true;
      }
      return last > first;
    };
    EXPECT_FALSE(grows(0.98 * K)) << delay;
    EXPECT_TRUE(grows(1.02 * K)) << delay;
  }
}

TEST(WallLimit, ControllerRaisesTheStabilityTenfoldAndHalfOfItIsUsedUnlessFrictionBoundsIt) {
  const DeviceProfile profile;
  const Matrix3d J = JacobianAt(0.15, profile);
  for (const double delay : {0.0, 0.001, 0.003}) {
    const WallLimit with =
        WallLimits(LimitOptions(profile), delay, 0.02, 0.3).Along(J, Tilted(0.3));
    const WallLimit without =
        WallLimits(LimitOptions(profile, false), delay, 0.02, 0.3).Along(J, Tilted(0.3));
    EXPECT_GT(with.stability, 10 * without.stability);
    EXPECT_EQ(with.friction, without.friction);
    EXPECT_EQ(with.Stiffness(), std::min(0.5 * with.stability, with.friction));
  }
}

TEST(WallLimit, ContinuousEncodersHaveNoLimitByFriction) {
  DeviceProfile profile;
  profile.encoder_step = profile.angle_encoder_step = 0;
  const WallLimit limit =
      WallLimits(LimitOptions(profile), 0, 0.02, 0.3).Along(JacobianAt(0.2, profile), Tilted(0.5));
  EXPECT_TRUE(std::isinf(limit.friction));
  EXPECT_EQ(limit.Stiffness(), 0.5 * limit.stability);
}

}  // namespace
}  // namespace hpdm
