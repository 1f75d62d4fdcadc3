#include "haptics/device/mouse_hand.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <thread>

#include "engine/base/error.h"
#include "haptics/device/sim_device.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kTick = 1'000'000;
constexpr double kW = 2 * std::numbers::pi * MouseHand::kBandwidth;  // 1/s

void Aim(MouseHand* hand, const HandTarget& target) {
  hand->targets().Back() = target;
  hand->targets().Publish();
}

TEST(MouseHand, StaysWhereItStartsUntilTheMouseMoves) {
  const HandTarget start = {Vector3d(0.01, -0.02, 0.03), 0.4, 0.2};
  MouseHand hand(start, 300, 6);
  for (Nanoseconds t = 0; t < 100 * kTick; t += kTick) {
    const HandIntent intent = hand.At(t);
    ASSERT_EQ(intent.p_W, start.p_W);
    ASSERT_EQ(intent.v_W, Vector3d::Zero());
    ASSERT_EQ(intent.roll, 0.4);
    ASSERT_EQ(intent.jaw, 0.2);
  }
}

TEST(MouseHand, ReachesATargetWithoutGoingPastIt) {
  MouseHand hand({}, 300, 6);
  Aim(&hand, {Vector3d(0.02, 0, -0.01), 1.0, 0.0});
  HandIntent last;
  for (Nanoseconds t = 0; t < 500 * kTick; t += kTick) {
    const HandIntent intent = hand.At(t);
    // Rounding of a sum near 0.02: 1e-17.
    ASSERT_LE(intent.p_W.x(), 0.02 + 1e-16);
    ASSERT_GE(intent.p_W.x(), last.p_W.x() - 1e-16);
    ASSERT_GE(intent.p_W.z(), -0.01 - 1e-16);
    ASSERT_LE(intent.roll, 1 + 1e-15);
    ASSERT_GE(intent.jaw, -1e-15);
    last = intent;
  }
  // After 25 time constants of 20 ms: (1 + 25) e^-25 is 4e-10 of the way.
  EXPECT_NEAR(last.p_W.x(), 0.02, 1e-10);
  EXPECT_NEAR(last.jaw, 0, 1e-9);
}

TEST(MouseHand, TheVelocityIsContinuousAndThePositionsDerivative) {
  MouseHand hand({}, 300, 6);
  // A mouse at 60 Hz that moves at 0.2 m/s in jumps of 3.3 mm, and stops.
  const double jump = 0.2 / 60;
  HandIntent last = hand.At(0);
  double fastest = 0;
  int spoken = 0;
  for (Nanoseconds t = kTick; t < 1000 * kTick; t += kTick) {
    if (t * 60 / kNanosecondsPerSecond > spoken && spoken < 24) {
      Aim(&hand, {Vector3d(++spoken * jump, 0, 0)});
    }
    const HandIntent intent = hand.At(t);
    // One jump accelerates by w^2 jump at most, in addition to earlier ones: the response to
    // a ramp of steps stays below w^2 jump / (1 - e^(-w / 60)).
    const double most = kW * kW * jump / (1 - std::exp(-kW / 60));
    ASSERT_LE(std::abs(intent.v_W.x() - last.v_W.x()), most * ToSeconds(kTick)) << t;
    // The trapezoid's error is h^3 x''' / 12, with x''' at most 3 w^3 jump.
    const double by_velocity = 0.5 * ToSeconds(kTick) * (intent.v_W.x() + last.v_W.x());
    const double trapezoid = std::pow(ToSeconds(kTick), 3) * kW * kW * kW * jump;
    ASSERT_NEAR(intent.p_W.x() - last.p_W.x(), by_velocity, trapezoid) << t;
    fastest = std::max(fastest, intent.v_W.x());
    last = intent;
  }
  // A staircase's velocity holds its own rate with twice the mean (a row of pulses), of which
  // 1 / (1 + (60 / 8)^2) = 1.7 % comes through, and 0.4 % of the next harmonic.
  EXPECT_NEAR(fastest, 0.2, 2 * 0.022 * 0.2);
  // 0.6 s later, 30 time constants: 31 e^-30 of the way.
  EXPECT_NEAR(last.p_W.x(), 24 * jump, 1e-12);
}

TEST(MouseHand, TicksOfAnyLengthEndAtTheSamePlace) {
  MouseHand often({}, 300, 6), seldom({}, 300, 6);
  Aim(&often, {Vector3d(0.01, 0, 0)});
  Aim(&seldom, {Vector3d(0.01, 0, 0)});
  for (Nanoseconds t = 0; t <= 60 * kTick; t += kTick) often.At(t);
  seldom.At(0);
  // The integration is exact: sixty steps round differently from one.
  EXPECT_NEAR(seldom.At(60 * kTick).p_W.x(), often.At(60 * kTick).p_W.x(), 1e-16);
}

TEST(MouseHand, MovesASimulatedDeviceThatTissueHoldsBack) {
  const DeviceProfile profile;
  const ImpulseEngineKinematics kinematics(Vector3d(0, 0, 0.15), Vector3d(0, 0, -1), profile);
  const HandTarget start = {Vector3d(0, 0, 0.05)};
  auto owned = std::make_unique<MouseHand>(start, 300, 6);
  MouseHand& hand = *owned;
  SimDevice device(profile, kinematics, std::move(owned));
  device.Home();
  device.EnableForce(true);
  Aim(&hand, {Vector3d(0, 0, 0.02)});
  Vector3d p_W = Vector3d::Zero();
  for (Nanoseconds t = 0; t < 1000 * kTick; t += kTick) {
    p_W = kinematics.Forward(device.Read(t).joints).translation();
    // Tissue of 200 N/m below z = 0.04.
    const double force = std::max(0.0, 200 * (0.04 - p_W.z()));
    device.Write(kinematics.Jacobian(device.joints()).transpose() * Vector3d(0, 0, force));
  }
  // Two springs in series: 300 (z - 0.02) = 200 (0.04 - z), plus Coulomb friction of 0.1 N over
  // both and the encoder's step.
  EXPECT_NEAR(p_W.z(), 0.028, 0.1 / 500 + 5e-5);
}

// The race detector checks this exchange.
TEST(MouseHand, ATargetCrossesThreadsWhole) {
  MouseHand hand({}, 300, 6);
  std::jthread window([&hand](std::stop_token stop) {
    for (int i = 0; !stop.stop_requested(); i = (i + 1) % 100) {
      Aim(&hand, {Vector3d::Constant(1e-4 * i), 0.01 * i, 0.01 * i});
    }
  });
  for (Nanoseconds t = 0; t < 2000 * kTick; t += kTick) {
    const HandIntent intent = hand.At(t);
    // The coordinates of every target are equal, and all are filtered alike.
    ASSERT_EQ(intent.p_W.x(), intent.p_W.z());
    ASSERT_NEAR(intent.roll, 100 * intent.p_W.x(), 1e-12);
  }
}

TEST(MouseHand, RefusesAnImpedanceThatPushes) {
  EXPECT_THROW(MouseHand({}, -1, 6), InputError);
  EXPECT_THROW(MouseHand({}, 300, std::numeric_limits<double>::quiet_NaN()), InputError);
}

}  // namespace
}  // namespace hpdm
