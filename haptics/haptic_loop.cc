#include "haptics/haptic_loop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// The tip's velocity is the difference of two quantised positions, filtered by a first-order
// low-pass. At 30 Hz the noise of a 25 um encoder step at 1 kHz falls from 25 to 4 mm/s. The delay
// of 5 ms is short beside the 33 ms of a deformation step, which uses the velocity to look ahead.
constexpr double kVelocityCutoff = 30;  // Hz

// Part of soft tissue's force that the energy tank takes without a flag: below what a hand notices.
constexpr double kTankShown = 0.01;

// 0 in lockstep.
Nanoseconds SinceWakeUp(Nanoseconds scheduled, const TickTiming& timing) {
  return timing.clock == nullptr ? 0 : timing.clock->Now() - scheduled - timing.wake_late_ns;
}

/// True if a sample marked valid is plausible: beyond these limits velocities and time differences
/// would not be finite.
bool IsPose(const DeviceSample& sample, Nanoseconds now) {
  constexpr double kMaxJoint = 1e6;  // rad, m
  constexpr Nanoseconds kFurthest = 3600 * kNanosecondsPerSecond;
  return (sample.joints.array().abs() <= kMaxJoint).all() && sample.time_ns <= now + kFurthest &&
         sample.time_ns >= now - kFurthest;
}

EnergyTankOptions TankOf(const std::vector<HapticInstrument>& instruments, Nanoseconds period_ns) {
  EnergyTankOptions options;
  options.period = ToSeconds(period_ns);
  for (const HapticInstrument& instrument : instruments) {
    const PassivityOptions& passivity = instrument.passivity;
    options.control = options.control && passivity.control && passivity.still;
  }
  return options;
}

}  // namespace

HapticLoop::HapticLoop(std::vector<HapticInstrument> instruments, Nanoseconds period_ns,
                       const Edges& edges)
    : tank_(TankOf(instruments, period_ns)), period_ns_(period_ns), edges_(edges) {
  HPDM_CHECK(instruments.size() <= kMaxInstruments);
  HPDM_CHECK(period_ns > 0);
  tools_.reserve(instruments.size());
  for (HapticInstrument& instrument : instruments) {
    HPDM_CHECK(instrument.device != nullptr);
    instrument.guard.period = ToSeconds(period_ns);
    instrument.passivity.period = ToSeconds(period_ns);
    instrument.passivity.max_force_rate = instrument.guard.max_force_rate;
    Tool& tool = tools_.emplace_back(instrument, ToSeconds(period_ns));
    // Until the device answers, the tool stays at the least insertion with its jaw open.
    tool.sample.joints[kInsertion] = instrument.kinematics.limits().min_joints[kInsertion];
    tool.sample.joints[kJaw] = 1;
    tool.pose.p_trocar_W = instrument.kinematics.p_trocar_W();
  }
}

void HapticLoop::Attach(std::span<const std::unique_ptr<Device>> devices, const Edges& edges) {
  HPDM_CHECK(devices.size() == tools_.size());
  edges_ = edges;
  const ContactPatch& patch = edges_->patches.Front();
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    tools_[i].instrument.device = devices[i].get();
    tools_[i].contacts.Rebind(patch.tools[i]);
  }
}

void HapticLoop::Tick(std::uint64_t tick, Nanoseconds scheduled,
                      const TickTiming& timing) noexcept {
  const Nanoseconds now = scheduled + timing.wake_late_ns;
  ApplyControl(tick);
  ReadDevices(now);
  MoveTools(now);
  TakePatch(scheduled);
  EvaluateContacts(scheduled);
  LimitTissue();
  DampContacts(now);
  GuardForces(scheduled);
  WriteEfforts();
  sample_.written_ns = SinceWakeUp(scheduled, timing);
  ObserveEnergy();
  PublishToolState(tick, scheduled);
  FillSample(tick, scheduled, timing);
  PushToLink();
  edges_->samples.Push(sample_);
}

std::uint64_t HapticLoop::RampOutTicks() const {
  return static_cast<std::uint64_t>(std::max<Nanoseconds>(1, kStopTime / period_ns_ - 1));
}

// The contact plays no part: a hand that presses on could let its force grow.
void HapticLoop::RampOut(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing,
                         std::uint64_t left) noexcept {
  const Nanoseconds now = scheduled + timing.wake_late_ns;
  ReadDevices(now);
  MoveTools(now);
  const double share = static_cast<double>(left) / static_cast<double>(RampOutTicks());
  for (Tool& tool : tools_) {
    tool.force_on = tool.instrument.device->ForceOn();
    tool.safe = tool.guard.RampOut(share, tool.force_on);
  }
  WriteEfforts();
  sample_.written_ns = SinceWakeUp(scheduled, timing);
  FillSample(tick, scheduled, timing);
  PushToLink();
}

TickCount HapticLoop::RunRealClock(std::stop_token stop, LoopClock& clock, Nanoseconds start_ns,
                                   std::uint64_t end_tick) {
  const TickCount count =
      RunOnSchedule({start_ns, period_ns_, end_tick}, stop, clock,
                    [this](std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing) {
                      Tick(tick, scheduled, timing);
                    });
  RampOutOnRealClock(clock, start_ns, count.Periods());
  return count;
}

void HapticLoop::RampOutOnRealClock(LoopClock& clock, Nanoseconds start_ns,
                                    std::uint64_t first_tick) {
  const Nanoseconds due = start_ns + static_cast<Nanoseconds>(first_tick) * period_ns_;
  const std::uint64_t ticks = RampOutTicks();
  std::uint64_t left = ticks;
  RunOnSchedule({std::max(due, clock.Now()), period_ns_, ticks}, {}, clock,
                [&](std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing) {
                  left = ticks - 1 - tick;
                  RampOut(first_tick + tick, scheduled, timing, left);
                });
  // The last periods were skipped.
  if (left > 0) RampOut(first_tick + ticks, clock.Now(), {.clock = &clock}, 0);
}

void HapticLoop::EmergencyStop() noexcept {
  for (Tool& tool : tools_) tool.instrument.device->EmergencyStop();
}

void HapticLoop::ApplyControl(std::uint64_t tick) {
  if (edges_->control == nullptr) return;
  edges_->control->Update();
  const SessionControl& asked = edges_->control->Front();
  paused_ = asked.paused;
  if (asked.restart.count != restart_.count) Restart(asked.restart, tick);
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    Tool& tool = tools_[i];
    tool.pedal_asked = asked.pedal[i];
    const int instrument_index = asked.instrument_index[i];
    const bool has = instrument_index >= 0 &&
                     static_cast<std::size_t>(instrument_index) < tool.instrument.geometries.size();
    if (!has || instrument_index == tool.pose.instrument_index || !tool.contacts.IsFree()) continue;
    tool.pose.instrument_index = instrument_index;
    tool.contacts.ClearPatches();
    tool.guard.RampIn();
  }
}

void HapticLoop::Restart(const RestartRequest& request, std::uint64_t tick) {
  restart_ = request;
  restart_tick_ = tick;
  for (Tool& tool : tools_) {
    tool.contacts.ClearPatches();
    tool.guard.RampIn();
  }
}

void HapticLoop::ReadDevices(Nanoseconds now) {
  if (paused_) return;
  for (Tool& tool : tools_) {
    DeviceSample sample = tool.instrument.device->Read(now);
    if (sample.valid && IsPose(sample, now)) {
      tool.sample = sample;
      device_time_ns_ = std::max(device_time_ns_, sample.time_ns);
    } else {
      tool.sample.valid = false;
    }
  }
}

void HapticLoop::MoveTools(Nanoseconds now) {
  for (Tool& tool : tools_) {
    const ImpulseEngineKinematics& kinematics = tool.instrument.kinematics;
    const JointVector& joints = tool.sample.joints;
    const Isometry3d X_WT = kinematics.Forward(joints);
    const double dt = ToSeconds(tool.sample.time_ns - tool.moved_ns);
    const auto blend = [](double seconds) {
      return 1 - std::exp(-2 * std::numbers::pi * kVelocityCutoff * seconds);
    };
    if (!tool.sample.valid || paused_) {
      tool.pose.v_tip_W.setZero();
    } else if (tool.has_pose && dt > 0) {
      const Vector3d raw = (X_WT.translation() - tool.pose.X_WT.translation()) / dt;
      tool.pose.v_tip_W += blend(dt) * (raw - tool.pose.v_tip_W);
    } else if (now - tool.sample.time_ns > kHeldAfter) {
      tool.pose.v_tip_W *= 1 - blend(ToSeconds(period_ns_));
    }
    // The device's motion during a pause does not count as motion of the tool.
    tool.has_pose = !paused_ && (tool.has_pose || tool.sample.valid);
    tool.moved_ns = tool.sample.time_ns;
    tool.pose.X_WT = X_WT;
    const bool closed = joints[kJaw] < kJawGrasps;
    if (!closed || tool.pose.jaw >= kJawGrasps) tool.X_WC = X_WT;
    tool.pose.X_TC = closed ? X_WT.inverse() * tool.X_WC : Isometry3d::Identity();
    tool.pose.jaw = joints[kJaw];
    tool.pose.pedal = !paused_ && tool.sample.valid && now - tool.sample.time_ns <= kHeldAfter &&
                      (tool.pedal_asked || tool.sample.pedal);
    tool.J = kinematics.Jacobian(joints);
  }
}

void HapticLoop::TakePatch(Nanoseconds scheduled) {
  const bool is_new = edges_->patches.Update();
  const ContactPatch& patch = edges_->patches.Front();
  if (is_new) {
    patch_number_ = patch.step.number;
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      if (static_cast<int>(i) < patch.tool_count && patch.step.input_tick >= restart_tick_ &&
          patch.tools[i].instrument_index == tools_[i].pose.instrument_index) {
        tools_[i].contacts.SetPatches(patch.tools[i]);
      } else {
        tools_[i].contacts.ClearPatches();
      }
    }
  }
  patch_age_ns_ = patch_number_ > 0 ? scheduled - patch.step.device_time_ns : 0;
}

void HapticLoop::EvaluateContacts(Nanoseconds scheduled) {
  std::array<TipContacts*, kMaxInstruments> contacts;
  for (std::size_t t = 0; t < tools_.size(); ++t) contacts[t] = &tools_[t].contacts;
  TipContacts::StandOnMoved(std::span(contacts).first(tools_.size()));
  for (Tool& tool : tools_) {
    tool.contacts.Locate({.time_ns = scheduled,
                          .X_WT = tool.pose.X_WT,
                          .jaw = tool.pose.jaw,
                          .tip_radius = tool.Geometry().tip_radius,
                          .friction = tool.Geometry().friction,
                          .shaft_radius = tool.Geometry().shaft_radius,
                          .from_trocar = tool.sample.joints[kInsertion],
                          .tip_part = tool.Geometry().JawsLength()});
  }
  TipContacts::Solve(std::span(contacts).first(tools_.size()));
}

// Returns the friction in the trocar as a force at the tip. The columns of J are orthogonal, so a
// force along one of them has an effort on that axis only.
Vector3d HapticLoop::TrocarForce(Tool* tool) const {
  Vector3d force_W = Vector3d::Zero();
  if (!tool->trocar_friction.IsOn() || !tool->has_pose) return force_W;
  const AxisEffort effort = tool->trocar_friction.Effort(tool->sample.joints.head<3>());
  for (int i = 0; i < 3; ++i) force_W += effort[i] / tool->J.col(i).squaredNorm() * tool->J.col(i);
  return force_W;
}

// The energy tank's share of soft tissue; walls keep their force.
void HapticLoop::LimitTissue() {
  std::array<EnergyTank::Press, kMaxInstruments> presses;
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const HapticForce& contact = tools_[i].contacts.result();
    presses[i] = {tools_[i].pose.X_WT.translation(), contact.reaction_W, contact.tissue_stored,
                  contact.stored, contact.kind};
  }
  tank_takes_ = 1 - tank_.Limit(std::span(presses).first(tools_.size()));
  for (Tool& tool : tools_) {
    const HapticForce& contact = tool.contacts.result();
    tool.reaction_W = contact.reaction_W;
    if (tank_takes_ > 0) tool.reaction_W -= tank_takes_ * (contact.reaction_W - contact.wall_W);
  }
}

void HapticLoop::DampContacts(Nanoseconds now) {
  for (Tool& tool : tools_) {
    const HapticForce& contact = tool.contacts.result();
    tool.damping_force_W = tool.passivity.Damp(
        now, tool.sample, tool.pose.X_WT.translation(), tool.J, tool.reaction_W,
        {contact.stored, contact.wall_W, contact.p_tip_organ_W}, TrocarForce(&tool));
  }
}

void HapticLoop::GuardForces(Nanoseconds scheduled) {
  const Nanoseconds elapsed = has_run_ ? scheduled - last_scheduled_ns_ : period_ns_;
  for (Tool& tool : tools_) {
    tool.force_on = tool.instrument.device->ForceOn();
    tool.safe = tool.guard.Filter({.reaction_W = tool.reaction_W + tool.damping_force_W,
                                   .J = tool.J,
                                   .elapsed = ToSeconds(elapsed),
                                   .has_patch = patch_number_ > 0,
                                   .patch_age_ns = patch_age_ns_,
                                   .device_valid = tool.sample.valid,
                                   .force_on = tool.force_on,
                                   .paused = paused_});
  }
  last_scheduled_ns_ = scheduled;
  has_run_ = true;
}

void HapticLoop::WriteEfforts() {
  for (Tool& tool : tools_) {
    tool.effort = tool.J.transpose() * tool.safe.force_W;
    tool.instrument.device->Write(tool.effort);
  }
}

void HapticLoop::ObserveEnergy() {
  std::array<Vector3d, kMaxInstruments> forces_W;
  for (std::size_t i = 0; i < tools_.size(); ++i) forces_W[i] = tools_[i].safe.force_W;
  tank_.Observe(std::span(forces_W).first(tools_.size()));
  for (Tool& tool : tools_) {
    tool.passivity.Observe(tool.safe.force_W, tool.safe.authority,
                           (tool.safe.flags & kGuardDisabled) == 0);
    if (tool.passivity.damping() > 0) tool.safe.flags |= kGuardPassivity;
    if (tank_takes_ > kTankShown && tool.contacts.result().tissue_stored > 0) {
      tool.safe.flags |= kGuardTank;
    }
    if (tool.trocar_friction.IsOn()) tool.safe.flags |= kGuardTrocar;
  }
}

void HapticLoop::PublishToolState(std::uint64_t tick, Nanoseconds scheduled) {
  ToolState& state = edges_->tool_states.Back();
  state.tick = tick;
  state.time_ns = scheduled;
  state.device_time_ns = device_time_ns_;
  state.tool_count = static_cast<int>(tools_.size());
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    state.tools[i] = tools_[i].pose;
    state.contact_points[i] = tools_[i].contacts.contact_points();
  }
  state.restart = restart_;
  edges_->tool_states.Publish();
}

void HapticLoop::FillSample(std::uint64_t tick, Nanoseconds scheduled, const TickTiming& timing) {
  sample_.tick = tick;
  sample_.time_ns = scheduled;
  sample_.device_time_ns = device_time_ns_;
  if (sample_.patch_number != patch_number_) sample_.patch_tick = tick;
  sample_.patch_number = patch_number_;
  sample_.patch_age_ns = patch_age_ns_;
  sample_.wake_late_ns = timing.wake_late_ns;
  sample_.skipped = timing.skipped;
  sample_.paused = paused_;
  sample_.restart = restart_;
  sample_.tool_count = static_cast<int>(tools_.size());
  for (std::size_t i = 0; i < tools_.size(); ++i) {
    const Tool& tool = tools_[i];
    sample_.tools[i] = {.joints = tool.sample.joints,
                        .p_tip_W = tool.pose.X_WT.translation(),
                        .v_tip_W = tool.pose.v_tip_W,
                        .reaction_W = tool.contacts.result().reaction_W,
                        .force_W = tool.safe.force_W,
                        .effort = tool.effort,
                        .depth = tool.contacts.result().depth,
                        .organ = tool.contacts.result().organ,
                        .kind = tool.contacts.result().kind,
                        .guard_flags = tool.safe.flags,
                        .slip = tool.contacts.result().slip,
                        .energy = tool.passivity.energy(),
                        .damping = tool.passivity.damping(),
                        .device_time_ns = tool.sample.time_ns,
                        .device_valid = tool.sample.valid,
                        .force_on = tool.force_on,
                        .pedal = tool.pose.pedal,
                        .instrument_index = tool.pose.instrument_index};
  }
  sample_.compute_ns = SinceWakeUp(scheduled, timing);
}

void HapticLoop::PushToLink() {
  if (edges_->link != nullptr) edges_->link->Push(sample_);
}

}  // namespace hpdm
