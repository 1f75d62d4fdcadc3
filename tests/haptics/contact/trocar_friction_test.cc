#include "haptics/contact/trocar_friction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <numbers>
#include <vector>

#include "haptics/haptic_loop.h"
#include "tests/support/contact_patches.h"
#include "tests/support/hand_plant.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kTrocarPeriod = 1'000'000;
constexpr double kTrocarLever = 0.15;  // m

// A real loop with a device in a hand, in free motion 40 mm above a surface.
class TrocarBench {
 public:
  TrocarBench(const TrocarFrictionOptions& friction, HandPlant::Hand hand,
              const DeviceProfile& profile = {})
      : kinematics_({0, 0, kTrocarLever}, -Vector3d::UnitZ(), profile),
        device(profile, kinematics_, Vector3d::Zero(), Vector3d::Zero(), std::move(hand)) {
    device.Home();
    device.EnableForce(true);
    HapticInstrument instrument{&device, kinematics_, {{.tip_radius = 0.0025}}};
    instrument.guard.ramp_in = 1e-9;  // the start of a session is not judged here
    instrument.passivity.device = AxesOf(profile);
    instrument.trocar_friction = friction;
    instrument.trocar_friction.delay = profile.delay;
    loop_ = std::make_unique<HapticLoop>(std::vector{instrument}, kTrocarPeriod,
                                         HapticLoop::Edges{tool_states_, patches_, samples_});
  }

  HapticSample Tick() {
    const Nanoseconds now = static_cast<Nanoseconds>(tick_) * kTrocarPeriod;
    if (tick_ % 33 == 0) {
      ContactPatch& patch = patches_.Back();
      patch.step.number = tick_ + 1;
      patch.step.device_time_ns = now;
      patch.tool_count = 1;
      ToolPatch& place = patch.tools[0].places[0];
      place = PlanePatch(7, 0.03, 100);
      for (PatchPoint& point : place.points) point.p_original_W.z() -= 0.04;
      place.Pack();
      patches_.Publish();
    }
    loop_->Tick(tick_++, now, {});
    HapticSample sample;
    EXPECT_TRUE(samples_.Pop(&sample));
    return sample;
  }

 private:
  ImpulseEngineKinematics kinematics_;

 public:
  HandPlant device;

 private:
  TripleBuffer<ToolState> tool_states_;
  TripleBuffer<ContactPatch> patches_;
  SpscQueue<HapticSample> samples_{4};
  std::unique_ptr<HapticLoop> loop_;
  std::uint64_t tick_ = 0;
};

// A hand that moves to and fro by `way_W` once a second, and rests from t = `end` on.
HandPlant::Hand ToAndFro(const Vector3d& way_W, double end) {
  return [=](double t) -> HandGrip {
    const double turn = 2 * std::numbers::pi * std::min(t, end);
    const double speed = t < end ? std::numbers::pi * std::sin(turn) : 0;
    return {2000, 20, 0.5 * (1 - std::cos(turn)) * way_W, speed * way_W};
  };
}

TEST(TrocarFriction, HandDoesTheWorkOfCoulombFrictionAlongTheShaftAndAboutThePivot) {
  const TrocarFrictionOptions friction{.force = 0.8, .torque = 0.03};
  for (const double delay : {0.0, 0.002}) {
    for (const bool along : {true, false}) {
      const Vector3d way_W = along ? Vector3d(0, 0, 0.03) : Vector3d(0.018, 0.024, 0);
      DeviceProfile profile;
      profile.delay = delay;
      TrocarBench bench(friction, ToAndFro(way_W, 4), profile);
      double work = 0, way = 0, peak = 0;
      Vector3d last = bench.device.q();
      AxisEffort held = AxisEffort::Zero();
      for (int k = 0; k < 4000; ++k) {
        const HapticSample sample = bench.Tick();
        const Vector3d moved = bench.device.q() - last;
        work -= held.dot(moved);
        way += along ? std::abs(moved[2]) : moved.head<2>().norm();
        last = bench.device.q();
        held = sample.tools[0].effort;
        peak = std::max(peak, along ? std::abs(held[2]) : held.head<2>().norm());
        EXPECT_LE(bench.device.given(), 1e-9) << "the motors give nothing, at any time";
      }
      const double coulomb = along ? friction.force : friction.torque;
      EXPECT_NEAR(peak, coulomb, 1e-6 * coulomb);
      // Coulomb's work over the way, less that of the springs: half the friction over their
      // stretch f / k at the start, and none over 2 f / k at each of the seven turns.
      const DeviceAxes axes = AxesOf(profile);
      const double stretch =
          coulomb * (1e-3 + 2 * delay) / axes.damping[along ? kInsertion : kPitch];
      const double expected = coulomb * (way - (7 * 2 + 0.5) * stretch);
      EXPECT_NEAR(work, expected, 0.03 * expected) << delay << ' ' << along;
    }
  }
}

TEST(TrocarFriction, HandAtRestFeelsNoVibration) {
  for (const double delay : {0.0, 0.003}) {
    DeviceProfile profile;
    profile.delay = delay;
    TrocarBench bench({.force = 3, .torque = 0.1}, ToAndFro({0.01, 0.02, 0.015}, 0.8), profile);
    Vector3d low = Vector3d::Constant(1e9), high = -low;
    for (int k = 0; k < 3000; ++k) {
      bench.Tick();
      if (k < 2000) continue;
      low = low.cwiseMin(bench.device.q());
      high = high.cwiseMax(bench.device.q());
    }
    const Vector3d counts = (high - low).cwiseQuotient(AxesOf(profile).encoder_step);
    EXPECT_LE(counts.maxCoeff(), 1) << delay;
  }
}

TEST(TrocarFriction, FigureOfZeroLeavesEveryBitAsItWas) {
  const auto hand = ToAndFro({0.01, 0.02, -0.05}, 10);  // presses the surface
  TrocarBench without({}, hand), zero({.force = 0, .torque = 0}, hand), with({.force = 0.1}, hand);
  bool differs = false;
  int presses = 0;
  for (int k = 0; k < 1500; ++k) {
    const ToolSample a = without.Tick().tools[0], b = zero.Tick().tools[0],
                     c = with.Tick().tools[0];
    for (const auto& [x, y] : {std::pair{a.force_W, b.force_W}, std::pair{a.effort, b.effort}}) {
      ASSERT_EQ(std::memcmp(x.data(), y.data(), sizeof x), 0) << k;
    }
    presses += a.kind == ContactKind::kPress;
    EXPECT_FALSE((a.guard_flags | b.guard_flags) & kGuardTrocar);
    EXPECT_TRUE(c.guard_flags & kGuardTrocar) << "so nobody takes the friction for the tissue's";
    differs = differs || a.force_W != c.force_W;
  }
  EXPECT_GT(presses, 100);
  EXPECT_TRUE(differs);
}

TEST(TrocarFriction, DeviceWithoutDampingDisplaysNone) {
  PassivityOptions passivity;
  passivity.device.damping.setZero();
  TrocarFriction friction({.force = 1, .torque = 0.1}, passivity);
  friction.Effort(Vector3d::Zero());
  EXPECT_EQ(friction.Effort({0.1, 0.1, 0.1}), AxisEffort::Zero());
}

}  // namespace
}  // namespace hpdm
