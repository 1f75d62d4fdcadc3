#include "tools/stress/stress_session_fixture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/base/check.h"
#include "haptics/device/switched_device.h"
#include "tools/shared/one_organ.h"
#include "tools/shared/report_text.h"

namespace hpdm {
namespace {

// A device with reach for every motion of the hands.
DeviceProfile FarReaching() {
  DeviceProfile profile;
  profile.max_angle = 1.5;
  profile.min_insertion = 1e-3;
  profile.max_insertion = 1;
  return profile;
}

ImpulseEngineKinematics Kinematics(const StressTool& tool) {
  return {tool.p_trocar_W, tool.motion(0).p_tip_W - tool.p_trocar_W, FarReaching()};
}

}  // namespace

std::function<StressPose(double)> Through(std::vector<std::pair<double, StressPose>> waypoints) {
  HPDM_CHECK(!waypoints.empty());
  return [waypoints = std::move(waypoints)](double t) {
    std::size_t next = 0;
    while (next < waypoints.size() && waypoints[next].first <= t) ++next;
    if (next == 0) return waypoints.front().second;
    const auto& [t_a, a] = waypoints[next - 1];
    if (next == waypoints.size()) return a;
    const auto& [t_b, b] = waypoints[next];
    const double along = (t - t_a) / (t_b - t_a);
    return StressPose{.p_tip_W = a.p_tip_W + along * (b.p_tip_W - a.p_tip_W),
                      .roll = a.roll + along * (b.roll - a.roll),
                      .jaw = a.jaw + along * (b.jaw - a.jaw)};
  };
}

std::string Harm(const StressOutcome& outcome, double released) {
  constexpr double kToRest = 1. / 30 + 0.1;  // s: a step, its delay and the rest of a decay
  const double limit = ForceGuardOptions().max_force * (1 + 1e-12);
  if (!outcome.finite || (outcome.flags & kStepNotFinite) != 0) return "not finite";
  if (outcome.force > limit) return Format("%.3g N on the hand", outcome.force);
  if (outcome.force_change > 1 + 1e-9) {
    return Format("force step of %.3g slew limits", outcome.force_change);
  }
  if (outcome.last_off_rest >= released + kToRest) {
    // Inverted tissue has no outside: a tip in it may press until it is far away.
    const bool ends = outcome.displacement < StressSessionFixture::kAtRest;
    if (ends && outcome.inverted_share > 0) return "";
    if (ends) return "slow to come to rest";
    return Format("%.2g mm stay", 1e3 * outcome.displacement);
  }
  return "";
}

std::string FaultBeforeGuard(const StressOutcome& outcome) {
  constexpr double kOverTissue = 1.5;  // a tick may come between two steps
  const double limit = ForceGuardOptions().max_force * (1 + 1e-12);
  if (outcome.reaction > std::max(limit, kOverTissue * outcome.tissue_force)) {
    return Format("%.3g N before the guard, %.3g N in the organ", outcome.reaction,
                  outcome.tissue_force);
  }
  if (outcome.reaction_change > 1 + 1e-9) {
    return Format("force step of %.3g slew limits before the guard", outcome.reaction_change);
  }
  return "";
}

void AddFaults(const StressOutcome& outcome, double released, StressTrial* trial) {
  trial->harm = Harm(outcome, released);
  const std::string fault = FaultBeforeGuard(outcome);
  if (fault.empty()) return;
  trial->fate = StressFate::kFailed;
  if (trial->how.empty()) trial->how = fault;
}

// The device's roll stays within a turn of zero.
static JointVector JointsOf(const ImpulseEngineKinematics& kinematics, const StressPose& pose) {
  const double roll = std::remainder(pose.roll, 2 * std::numbers::pi);
  return kinematics.Inverse(pose.p_tip_W, roll, pose.jaw).joints;
}

Isometry3d ToolFrame(const StressTool& tool, double t) {
  const ImpulseEngineKinematics kinematics = Kinematics(tool);
  return kinematics.Forward(JointsOf(kinematics, tool.motion(t)));
}

// A device that is always at the motion's pose.
class StressSessionFixture::Scripted final : public SwitchedDevice {
 public:
  Scripted(std::function<StressPose(double)> motion, const ImpulseEngineKinematics& kinematics)
      : motion_(std::move(motion)), kinematics_(kinematics) {}
  DeviceSample Read(Nanoseconds now) noexcept override {
    const StressPose pose = motion_(ToSeconds(now));
    return {.sequence = ++sequence_,
            .time_ns = now,
            .joints = JointsOf(kinematics_, pose),
            .valid = true};
  }
  void Write(const AxisEffort& /*effort*/) noexcept override {}
  DeviceLimits limits() const noexcept override { return LimitsOf(FarReaching()); }

 private:
  std::function<StressPose(double)> motion_;
  ImpulseEngineKinematics kinematics_;
  std::uint64_t sequence_ = 0;
};

StressSessionFixture::StressSessionFixture(const OrganOptions& organ, SurfaceMesh rest,
                                           std::vector<StressTool> tools,
                                           const TimingOptions& timing)
    : timing_(timing),
      organs_(OneOrgan(organ, std::move(rest))),
      render_(SizedSnapshot(organs_, static_cast<int>(tools.size()), true)),
      telemetry_(SizedSnapshot(organs_, static_cast<int>(tools.size()), false)) {
  const Nanoseconds period = kNanosecondsPerSecond / timing.haptic_hz;
  const Nanoseconds step = kNanosecondsPerSecond / timing.deformation_hz;
  ForceGuardOptions guard;
  guard.stale_age_ns = 4 * step;
  slew_ = guard.max_force_rate * ToSeconds(period);
  std::vector<ToolOptions> options;
  std::vector<HapticInstrument> instruments;
  for (const StressTool& tool : tools) {
    const ImpulseEngineKinematics kinematics = Kinematics(tool);
    devices_.push_back(tool.device ? tool.device(kinematics)
                                   : std::make_unique<Scripted>(tool.motion, kinematics));
    devices_.back()->Home();
    devices_.back()->EnableForce(true);
    options.push_back(tool.tool);
    options.back().prefetch = 1.5 * ToSeconds(step);
    instruments.push_back({devices_.back().get(), kinematics, tool.tool.geometries, guard});
  }
  deformation_ = std::make_unique<DeformationLoop>(
      organs_, options, DeformationEdges{tool_states_, patches_, render_, telemetry_, &steps_});
  haptics_ = std::make_unique<HapticLoop>(
      std::move(instruments), period,
      HapticLoop::Edges{tool_states_, patches_, ticks_, nullptr, &control_});
  clock_ = std::make_unique<Lockstep>(timing, haptics_.get(), deformation_.get());
}

StressSessionFixture::~StressSessionFixture() = default;

void StressSessionFixture::RunUntil(double seconds, std::vector<ToolSample>* series,
                                    ContactRecord* record) {
  const auto end = static_cast<std::uint64_t>(seconds * timing_.haptic_hz);
  while (clock_->tick() < end) {
    if (clock_->StepIfDue()) {
      MeasureStep();
      if (record != nullptr) record->stored.push_back(EnergyAfterStep());
    }
    clock_->Tick();
    MeasureTick();
    if (series != nullptr) series->push_back(tick_.tools[0]);
    if (record != nullptr) RecordContact(record);
  }
}

StoredEnergy StressSessionFixture::EnergyAfterStep() {
  if (organ().options().material.prony.count == 0) {
    return {step_.step.input_tick, EnergyInOrgan(organ(), state())};
  }
  if (viscous_ == nullptr) viscous_ = std::make_unique<ViscousEnergy>(organ());
  viscous_->Add(state(), 1.0 / timing_.deformation_hz);
  return {step_.step.input_tick, viscous_->stored(), viscous_->dissipated()};
}

// A place's way over the tissue is measured on the deformed surface of the newest step.
void StressSessionFixture::RecordContact(ContactRecord* record) {
  const ToolSample& tool = tick_.tools[0];
  ContactTick& tick = record->ticks.emplace_back();
  tick = {.kind = tool.kind,
          .p_tip_W = tool.p_tip_W,
          .reaction_W = tool.reaction_W,
          .force_W = tool.force_W};
  const TickContactPoint last = place_;
  place_ = deformation_->NewestTools().contact_points[0][0];  // there is one organ
  if (place_.triangle < 0) place_ = {};                       // on the coarse surface
  if (place_.organ < 0) return;
  tick.normal_W = place_.normal_W;
  tick.friction_W = place_.friction_W;
  if (last.organ < 0) return;
  const auto on_surface = [&](const TickContactPoint& place) {
    return SurfacePoint{place.triangle, place.weights}.Position(state().vertices,
                                                                organ().rest().triangles);
  };
  tick.slip_W = on_surface(place_) - on_surface(last);
}

void StressSessionFixture::Ask(const SessionControl& asked) {
  control_.Back() = asked;
  control_.Publish();
}

void StressSessionFixture::MeasureStep() {
  HPDM_CHECK(steps_.Pop(&step_));
  const OrganState& state = deformation_->organ(0);
  ++outcome_.steps;
  outcome_.flags |= step_.step.flags;
  if ((step_.step.flags & kStepBudgetSpent) != 0) ++outcome_.unconverged_steps;
  outcome_.largest_residual = std::max(outcome_.largest_residual, step_.step.residual);
  for (int t = 0; t < step_.tool_count; ++t) {
    const Vector3d& force_W = step_.contacts[t].force_on_tissue_W;
    outcome_.finite = outcome_.finite && force_W.allFinite();
    outcome_.tissue_force = std::max(outcome_.tissue_force, force_W.norm());
  }
  outcome_.finite = outcome_.finite && state.vertices.allFinite();
  outcome_.displacement = (state.vertices - organ().rest().vertices).rowwise().norm().maxCoeff();
  outcome_.largest_displacement = std::max(outcome_.largest_displacement, outcome_.displacement);
  if (!(outcome_.displacement <= kAtRest)) outcome_.last_off_rest = ToSeconds(step_.step.time_ns);
  if (organ().lattice_organ() == nullptr) return;
  const InversionDetector::Inversion inversion =
      organ().lattice_organ()->inversion_detector().EvaluateAll(state.contacts.refinement,
                                                                state.control_displacements);
  outcome_.least_determinant = std::min(outcome_.least_determinant, inversion.least);
  outcome_.inverted_share = std::max(outcome_.inverted_share, inversion.share);
}

void StressSessionFixture::MeasureTick() {
  const HapticSample last = tick_;
  HPDM_CHECK(ticks_.Pop(&tick_));
  for (int t = 0; t < tick_.tool_count; ++t) {
    const ToolSample& tool = tick_.tools[t];
    outcome_.finite = outcome_.finite && tool.force_W.allFinite() && tool.effort.allFinite() &&
                      tool.reaction_W.allFinite();
    outcome_.reaction = std::max(outcome_.reaction, tool.reaction_W.norm());
    const bool jumps = (tool.p_tip_W - last.tools[t].p_tip_W).norm() > StressOutcome::kMostWay;
    const bool lets_go =
        last.tools[t].kind == ContactKind::kGrasp && tool.kind != ContactKind::kGrasp;
    if (!jumps && !lets_go) {
      outcome_.reaction_change = std::max(
          outcome_.reaction_change, (tool.reaction_W - last.tools[t].reaction_W).norm() / slew_);
    }
    outcome_.force = std::max(outcome_.force, tool.force_W.norm());
    outcome_.force_change =
        std::max(outcome_.force_change, (tool.force_W - last.tools[t].force_W).norm() / slew_);
  }
}

}  // namespace hpdm
