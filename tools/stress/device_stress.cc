#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <random>
#include <utility>

#include "haptics/device/device_axes.h"
#include "haptics/device/external_device.h"
#include "haptics/device/sim_device.h"
#include "tools/shared/report_text.h"
#include "tools/stress/haptic_parts.h"
#include "tools/stress/stress_touch_fixture.h"

namespace hpdm {
namespace {

// A driver that loses a share of its readings.
class LossyDevice final : public Device {
 public:
  LossyDevice(std::function<StressPose(double)> motion, const ImpulseEngineKinematics& kinematics,
              double lost)
      : motion_(std::move(motion)),
        kinematics_(kinematics),
        lost_(lost),
        external_(kinematics.limits()) {}

  DeviceSample Read(Nanoseconds now) noexcept override {
    const StressPose pose = motion_(ToSeconds(now));
    const double draw = static_cast<double>(random_()) / static_cast<double>(random_.max());
    if (draw >= lost_) {
      external_.readings().Back() = {
          .sequence = ++sequence_,
          .time_ns = now,
          .joints = kinematics_.Inverse(pose.p_tip_W, pose.roll, pose.jaw).joints,
          .valid = true};
      external_.readings().Publish();
    }
    return external_.Read(now);
  }
  void Write(const AxisEffort& effort) noexcept override { external_.Write(effort); }
  void Home() override { external_.Home(); }
  void EnableForce(bool on) noexcept override { external_.EnableForce(on); }
  void EmergencyStop() noexcept override { external_.EmergencyStop(); }
  bool ForceOn() const noexcept override { return external_.ForceOn(); }
  DeviceLimits limits() const noexcept override { return external_.limits(); }

 private:
  std::function<StressPose(double)> motion_;
  ImpulseEngineKinematics kinematics_;
  double lost_;
  std::minstd_rand random_{7};
  std::uint64_t sequence_ = 0;
  ExternalDevice external_;
};

// A hand that follows a path and trembles along the vertical.
class TremblingHand final : public Hand {
 public:
  TremblingHand(std::function<StressPose(double)> motion, double amplitude, double hertz)
      : Hand(300, 6),
        motion_(std::move(motion)),
        amplitude_(amplitude),
        angular_frequency_(2 * std::numbers::pi * hertz) {}

  HandIntent At(Nanoseconds t_ns) noexcept override {
    constexpr double kBack = 5e-4;  // s
    const double t = ToSeconds(t_ns), angle = angular_frequency_ * t;
    const Vector3d p_W = motion_(t).p_tip_W;
    HandIntent intent{.p_W = p_W, .v_W = (p_W - motion_(t - kBack).p_tip_W) / kBack};
    intent.p_W.z() += amplitude_ * std::sin(angle);
    intent.v_W.z() += amplitude_ * angular_frequency_ * std::cos(angle);
    return intent;
  }

 private:
  std::function<StressPose(double)> motion_;
  double amplitude_;
  double angular_frequency_;
};

// Multiplies the stiffness by `factor`.
void Stiffen(double factor, StressTouchFixture* fixture, StressTool* tool) {
  fixture->organ.material.young *= factor;
  fixture->organ.energy.alpha *= factor;
  fixture->organ.energy.beta *= factor;
  tool->tool.k1 *= factor;
  tool->tool.k2 *= factor;
}

// Returns the lowest energy, J, that hand and device had put into the tissue since the forces were
// on, by the observer's data. It counts half of the device's own dissipation.
double LeastEnergy(const FeltTimeSeries& series) {
  const DeviceAxes axes = AxesOf(DeviceProfile{});
  double dissipated = 0, least = 0;
  for (std::size_t i = 1; i < series.size(); ++i) {
    for (int axis = 0; axis < 3 && series[i].kind == ContactKind::kPress; ++axis) {
      const double dq = series[i].joints[axis] - series[i - 1].joints[axis];
      dissipated +=
          0.5 * (axes.damping[axis] * dq * dq / 1e-3 + axes.friction[axis] * std::abs(dq));
    }
    least = std::min(least, series[i].energy + dissipated);
  }
  return least;
}

StressTrial Tremor(StressModel model, double stiffness, bool quick) {
  constexpr double kMeans = 0.01, kProbe = 0.002;              // m
  constexpr double kPressed = 0.9, kLeaves = 1.9, kOut = 2.2;  // s
  StressTouchFixture fixture = SoftOrgan(model, quick);
  const Vector3d top = fixture.Top(0.0, 0.004);
  const StressPose away = Below(top, -0.01), deep = Below(top, kMeans);
  StressTool tool = OverOrgan({{kRampedIn, away}, {kPressed, deep}, {kLeaves, deep}, {kOut, away}});
  tool.p_trocar_W = top + Vector3d(0.001, 0.001, 0.12);  // along the shaft
  const double soft = ForceGoneToSlowly(fixture, tool, away, Below(top, kProbe)).norm() / kProbe;
  Stiffen(stiffness / soft, &fixture, &tool);
  tool.device = [motion = tool.motion](const ImpulseEngineKinematics& kinematics) {
    return std::make_unique<SimDevice>(DeviceProfile{}, kinematics,
                                       std::make_unique<TremblingHand>(motion, 5e-4, 10));
  };
  const FeltTouch felt = Feel(fixture, tool, kOut + ToRest(model));
  constexpr int kFiner = 8;
  StressTouchFixture finely = fixture;
  finely.timing.haptic_hz *= kFiner;
  finely.timing.patch_delay_ticks *= kFiner;
  const FeltTouch finer = Feel(finely, tool, kOut + ToRest(model));
  FeltTimeSeries truth;
  for (std::size_t i = 0; i < finer.series.size(); i += kFiner) truth.push_back(finer.series[i]);
  truth.resize(felt.series.size());
  const double least = LeastEnergy(felt.series);
  const double error = FeltError(felt.series, truth, kPressed);
  StressTrial trial = JudgeTouch(model, error, 0.1, 0.5, felt.outcome, kOut);
  if (least < -1e-4) Fail(Format("%.2g mJ given to the hand", -1e3 * least), &trial);
  return trial;
}

StressTrial CoarseEncoders(StressModel model, double step_um, bool quick,
                           const KeptTimeSeries& kept) {
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  PressAndSlide way;
  StressTool tool = way.Tool(fixture.Top(0, 0.004));
  const FeltTimeSeries& exact =
      Kept(kept, model, [&] { return Feel(fixture, tool, way.out + ToRest(model)).series; });
  DeviceProfile coarse;
  coarse.encoder_step = 1e-6 * step_um;
  coarse.angle_encoder_step = coarse.encoder_step / 0.25;  // at the tip's distance from the trocar
  coarse.max_angle = 1.5;
  coarse.max_insertion = 1;
  const Vector3d home = tool.motion(0).p_tip_W - tool.p_trocar_W;
  const ImpulseEngineKinematics kinematics(tool.p_trocar_W, home, coarse);
  tool.motion = [motion = tool.motion, kinematics](double t) {
    const JointVector joints = kinematics.Inverse(motion(t).p_tip_W, 0, 1).joints;
    return StressPose{.p_tip_W = kinematics.Forward(kinematics.Quantise(joints)).translation()};
  };
  const FeltTouch felt = Feel(fixture, tool, way.out + ToRest(model));
  const double error = FeltError(felt.series, exact, kRampedIn);
  return JudgeTouch(model, error, 0.1, 0.5, felt.outcome, way.leaves);
}

StressTrial LostSamples(StressModel model, double percent, bool quick, const KeptTimeSeries& kept) {
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  PressAndSlide way;
  StressTool tool = way.Tool(fixture.Top(0, 0.004));
  const FeltTimeSeries& complete =
      Kept(kept, model, [&] { return Feel(fixture, tool, way.out + ToRest(model)).series; });
  tool.device = [motion = tool.motion, percent](const ImpulseEngineKinematics& kinematics) {
    return std::make_unique<LossyDevice>(motion, kinematics, percent / 100);
  };
  const FeltTouch felt = Feel(fixture, tool, way.out + ToRest(model));
  const double error = FeltError(felt.series, complete, kRampedIn);
  return JudgeTouch(model, error, 0.1, 0.5, felt.outcome, way.leaves + 0.05);
}

StressTrial NotANumber(StressModel model, double burst_ms, bool quick) {
  constexpr double kDepth = 0.01, kFirst = 1.3, kEvery = 0.1;  // m, s, s
  constexpr int kBursts = 3;
  const StressTouchFixture fixture = SoftOrgan(model, quick);
  const Vector3d top = fixture.Top(0.02, 0.01);
  const StressPose away = Below(top, -0.01), deep = Below(top, kDepth);
  const double burst = 1e-3 * burst_ms, last = kFirst + kBursts * (burst + kEvery);
  const double leaves = last + 0.6, out = leaves + 0.2;
  StressTool tool = OverOrgan({{kRampedIn, away}, {0.9, deep}, {leaves, deep}, {out, away}});
  tool.motion = [=, motion = tool.motion](double t) {
    const double since = std::fmod(t - kFirst, burst + kEvery);
    if (t < kFirst || t >= last || since >= burst) return motion(t);
    return StressPose{.p_tip_W = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN())};
  };
  const FeltTouch felt = Feel(fixture, tool, out + ToRest(model));
  const Vector3d before = MeanForce(felt.series, kFirst - 0.05, kFirst);
  double most = 0;
  for (auto i = std::lround(1e3 * kFirst); i < std::lround(1e3 * leaves); ++i) {
    most = std::max(most, felt.series[i].reaction_W.norm());
  }
  const double error = RelativeError(MeanForce(felt.series, leaves - 0.05, leaves), before);
  StressTrial trial = JudgeTouch(model, error, 0.1, 0.5, felt.outcome, leaves + 0.1);
  if (most > 1.1 * before.norm()) {
    Fail(Format("%.2g times the force", most / before.norm()), &trial);
  }
  return trial;
}

}  // namespace

std::vector<StressCase> DeviceStress(bool quick) {
  std::vector<StressCase> cases;
  cases.push_back(
      {.name = "tremor_at_passivity",
       .group = {},
       .title = "Hand that trembles 0.5 mm at 10 Hz on tissue at the device's stiffness limit",
       .truth = "the same hand and tissue at 8 kHz; degraded from 10 %, failed from 50 "
                "% of the peak, or from 0.1 mJ given to the hand",
       .parameter = {"stiffness", "N/m", 100, 1000, 30000, true},
       .models = {},
       .run = [quick](StressModel model, double value) { return Tremor(model, value, quick); }});
  cases.push_back({.name = "coarse_encoders",
                   .group = {},
                   .title = "Press and slide read by coarse encoders",
                   .truth =
                       "the force with exact ones; degraded from 10 %, failed from 50 % of the "
                       "peak",
                   .parameter = {"step", "um", 10, 100, 5000, true},
                   .models = {},
                   .run = [quick, kept = Keep()](StressModel model, double value) {
                     return CoarseEncoders(model, value, quick, kept);
                   }});
  cases.push_back({.name = "lost_samples",
                   .group = {},
                   .title = "Press and slide with readings lost at random",
                   .truth = "the force with all of them; degraded from 10 %, failed from 50 % of "
                            "the peak",
                   .parameter = {"share", "%", 10, 90, 99},
                   .models = {},
                   .run = [quick, kept = Keep()](StressModel model, double value) {
                     return LostSamples(model, value, quick, kept);
                   }});
  cases.push_back({.name = "bursts_of_nan",
                   .group = {},
                   .title = "Three bursts of readings that are not numbers, under a press",
                   .truth =
                       "the force before them, 0.6 s after; degraded from 10 %, failed from 50 "
                       "%, or 10 % more force at any time",
                   .parameter = {"burst", "ms", 1, 50, 500, true},
                   .models = {},
                   .run = [quick](StressModel model, double value) {
                     return NotANumber(model, value, quick);
                   }});
  return cases;
}

}  // namespace hpdm
