// Judges the virtual wall of a rigid organ: the real haptic loop, in the hand of a device that is
// simulated apart from it, gives no energy and does not vibrate.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "haptics/haptic_loop.h"
#include "haptics/safety/wall_limit.h"
#include "tests/support/contact_patches.h"
#include "tests/support/hand_plant.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kTickPeriod = 1'000'000;
constexpr double kWallTip = 0.0025;  // m, tip
constexpr double kHandStiffness = 300, kHandDamping = 6;

// A wall whose normal is tilted by asin(across) from the shaft of a tip `lever` from its trocar. It
// touches the tip at the origin.
struct WallCase {
  double lever = 0.18;  // m
  double across = 0;    // sine
  double turn = 0;      // rad, about the shaft: from pitch to yaw
  double delay = 0;     // s
  double friction = 0;  // of the tip on the wall
  double stronger = 1;  // the wall's stiffness over that of WallLimits
  bool control = true;  // passivity controller on
  double breath = 0;    // m: the organ rises along its normal and sinks, once in two seconds

  Vector3d normal_W() const {
    return {across * std::sin(turn), across * std::cos(turn), std::sqrt(1 - across * across)};
  }
};

enum class Play { kBlowFree, kBlowHeld, kHold, kLight, kGrip, kGripUndamped, kLetGo, kRub };

struct Verdict {
  double given = 0;   // J, most that the motors gave beyond the device's dissipation
  double buzz = 0;    // encoder counts, peak to peak in the last half second, worst axis
  double peak = 0;    // N
  double pushed = 0;  // m, farthest out of the tip from its place of touch, along the normal
  double depth = 0;   // m, tip below the surface in the last tick
  double force = 0;   // N, in the last tick
  double stiffness = 0;
};

WallStiffness StiffnessOf(const WallCase& wall, const PassivityOptions& passivity,
                          const Matrix3d& J) {
  const WallLimits limits(passivity, wall.delay, 0.02, 0.3);
  return {wall.stronger * limits.Along(J, wall.normal_W()).Stiffness(),
          wall.stronger * limits.InEveryDirection(J).Stiffness()};
}

ToolPatch WallPatch(const Vector3d& n_W, const WallStiffness& wall) {
  ToolPatch patch = PlanePatch(7, 0.03, 1);
  const Matrix3d R = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), n_W).toRotationMatrix();
  patch.reaction = ReactionType::kLattice;
  patch.rigid = true;
  for (int i = 0; i < patch.point_count; ++i) {
    PatchPoint& point = patch.points[i];
    point.p_original_W = R * point.p_original_W - kWallTip * n_W;
    point.normal_W = n_W;
    point.wall = wall;
    point.compliance_W = wall.Compliance(n_W);
  }
  patch.Pack();
  return patch;
}

// Approaches at `speed` (m/s) from 2 mm above the wall. The blows end 10 mm inside. The others
// reach 4 N (kLight: 1 N) of a hand's spring, and change their grip after a second; kRub then
// moves to and fro along the wall, 8 mm at 2 Hz.
HandPlant::Hand HandOf(Play play, double speed, const Vector3d& n_W) {
  return [=](double t) -> HandGrip {
    const bool blow = play == Play::kBlowFree || play == Play::kBlowHeld;
    const double end = blow ? 0.01 : (play == Play::kLight ? 1 : 4) / kHandStiffness;
    const double x = std::min(speed * t - 0.002, end);
    HandGrip grip{kHandStiffness, kHandDamping, -x * n_W,
                  x < end ? Vector3d(-speed * n_W) : Vector3d::Zero()};
    const bool changes = t >= 1;
    if (play == Play::kRub && changes) {
      const double turn = 4 * std::numbers::pi * (t - 1);
      const Vector3d along_W = n_W.unitOrthogonal();
      grip.p_W += 0.004 * (1 - std::cos(turn)) * along_W;
      grip.v_W += 0.016 * std::numbers::pi * std::sin(turn) * along_W;
    }
    if (play == Play::kBlowFree || (play == Play::kLetGo && changes)) return {};
    if (play == Play::kGripUndamped) grip.damping = 2;
    if ((play == Play::kGrip || play == Play::kGripUndamped) && changes) grip.stiffness *= 5;
    if (play == Play::kGrip && changes) grip.damping *= 5;
    return grip;
  };
}

Verdict Judge(const WallCase& wall, Play play, double speed = 0.05) {
  DeviceProfile profile;
  profile.delay = wall.delay;
  const ImpulseEngineKinematics kinematics({0, 0, wall.lever}, -Vector3d::UnitZ(), profile);
  const Vector3d n_W = wall.normal_W();
  const Vector3d start_W = 0.002 * n_W;
  HandPlant device(profile, kinematics, start_W, -speed * n_W, HandOf(play, speed, n_W));
  device.Home();
  device.EnableForce(true);
  HapticInstrument instrument{
      &device, kinematics, {{.tip_radius = kWallTip, .friction = wall.friction}}};
  instrument.guard.ramp_in = 1e-9;  // the start of a session is not judged here
  instrument.passivity.device = AxesOf(profile);
  const JointVector touching = kinematics.Inverse(Vector3d::Zero(), 0, 1).joints;
  const WallStiffness stiffness =
      StiffnessOf(wall, instrument.passivity, kinematics.Jacobian(touching));
  instrument.passivity.control = wall.control;
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples(2);  // overflows, since nothing reads it
  HapticLoop loop({instrument}, kTickPeriod, {tool_states, patches, samples});
  Verdict verdict{.stiffness = stiffness.normal};
  Vector3d low = Vector3d::Constant(1e9), high = -low;
  constexpr int kTicks = 2500;
  for (int tick = 0; tick < kTicks; ++tick) {
    const Nanoseconds now = tick * kTickPeriod;
    if (tick % 33 == 0) {
      ContactPatch& patch = patches.Back();
      patch.step.number = static_cast<std::uint64_t>(tick) + 1;
      patch.step.device_time_ns = now;
      patch.tool_count = 1;
      patch.tools[0].places[0] = WallPatch(n_W, stiffness);
      patch.tools[0].places[0].motion = {wall.breath * n_W, 0.5};
      patches.Publish();
    }
    loop.Tick(static_cast<std::uint64_t>(tick), now, {});
    const Vector3d p_W = device.p_W();
    verdict.pushed = std::max(verdict.pushed, n_W.dot(p_W));
    verdict.depth = -n_W.dot(p_W);
    verdict.force = n_W.dot(device.force_W());
    verdict.peak = std::max(verdict.peak, verdict.force);
    verdict.given = std::max(verdict.given, device.given());
    if (!device.q().allFinite()) verdict.given = std::numeric_limits<double>::infinity();
    if (tick < kTicks - 500) continue;
    low = low.cwiseMin(device.q());
    high = high.cwiseMax(device.q());
  }
  verdict.buzz = ((high - low).array() / AxesOf(profile).encoder_step.array()).maxCoeff();
  return verdict;
}

std::string WallName(const WallCase& wall) {
  return "lever " + std::to_string(wall.lever) + ", across " + std::to_string(wall.across) +
         ", delay " + std::to_string(wall.delay);
}

std::vector<WallCase> WallCases() {
  std::vector<WallCase> cases;
  for (const double lever : {0.1, 0.17, 0.24}) {
    for (const double across : {0.0, 0.4, 0.8, 1.0}) {
      cases.push_back({.lever = lever, .across = across, .turn = 0.6 * across});
    }
  }
  cases.push_back({.lever = 0.14, .across = 0.1, .delay = 0.001});
  cases.push_back({.lever = 0.2, .across = 0.7, .turn = 1.2, .delay = 0.001});
  cases.push_back({.lever = 0.2, .across = 0.3, .delay = 0.0034});
  return cases;
}

// J. A hand hardly feels less; a tip of 0.15 kg has it at 0.12 m/s.
constexpr double kAllowedEnergy = 1e-3;

TEST(RigidWall, BlowsGetNoEnergyBack) {
  for (const WallCase& wall : WallCases()) {
    for (const double speed : {0.1, 0.5}) {
      for (const Play play : {Play::kBlowFree, Play::kBlowHeld}) {
        EXPECT_LE(Judge(wall, play, speed).given, kAllowedEnergy)
            << WallName(wall) << ", " << speed << " m/s, "
            << (play == Play::kBlowFree ? "free" : "held");
      }
    }
  }
}

TEST(RigidWall, HandsThatHoldGripHarderOrLetGoGetNoEnergyAndFeelNoVibration) {
  for (const WallCase& wall : WallCases()) {
    for (const Play play :
         {Play::kHold, Play::kLight, Play::kGrip, Play::kGripUndamped, Play::kLetGo}) {
      const Verdict verdict = Judge(wall, play);
      EXPECT_LE(verdict.given, kAllowedEnergy)
          << WallName(wall) << ", play " << static_cast<int>(play);
      // Without a hand, and in one without damping, the device moves of itself.
      if (play == Play::kLetGo || play == Play::kGripUndamped) continue;
      EXPECT_LE(verdict.buzz, 1) << WallName(wall) << ", play " << static_cast<int>(play);
    }
  }
}

TEST(RigidWall, WallAtRestIsAsStiffAsItsFigure) {
  // The energy that is put in slowly covers all of the wall's: the tip comes to rest where k times
  // its depth is the force, up to an encoder's step and the device's friction.
  for (const WallCase& wall : WallCases()) {
    const Verdict verdict = Judge(wall, Play::kHold);
    const double expected = verdict.stiffness * verdict.depth;
    const double step = 2.5e-5 + 1e-4 * wall.lever;
    EXPECT_NEAR(verdict.force, expected, 0.5 * step * verdict.stiffness + 0.05 * expected)
        << WallName(wall);
    EXPECT_GT(verdict.force, 2.5) << WallName(wall);
  }
}

TEST(RigidWall, OrganThatMovesPushesAHandThatHoldsStill) {
  // The organ's own motion does the work, so the limit of the energy does not hold it back: the tip
  // stays within the wall's own depth of the surface, which rises by 5 mm.
  const WallCase wall{.lever = 0.17, .across = 0.4, .breath = 0.005};
  const Verdict verdict = Judge(wall, Play::kLight);
  EXPECT_GT(verdict.pushed, 0.005 - 3 / verdict.stiffness);
  EXPECT_GT(verdict.peak, 1.5);
}

TEST(RigidWall, TipThatStopsAndSlipsByFrictionGetsNoEnergy) {
  for (WallCase wall : WallCases()) {
    wall.friction = 0.3;
    for (const Play play : {Play::kRub, Play::kHold}) {
      const Verdict verdict = Judge(wall, play);
      EXPECT_LE(verdict.given, kAllowedEnergy) << WallName(wall);
      EXPECT_LE(play == Play::kHold ? verdict.buzz : 0, 1) << WallName(wall);
    }
  }
}

// The judgement can fail.
TEST(RigidWall, WithoutTheControllerOrMuchBeyondTheLimitItGivesEnergyOrVibrates) {
  WallCase wall{.lever = 0.17};
  wall.control = false;
  EXPECT_GT(Judge(wall, Play::kBlowFree, 0.5).given, 5 * kAllowedEnergy);
  EXPECT_GT(Judge({.lever = 0.14, .across = 0.1, .delay = 0.001, .stronger = 4}, Play::kHold).buzz,
            10);
}

}  // namespace
}  // namespace hpdm
