#include "haptics/device/sim_device.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "haptics/device/device_axes.h"

namespace hpdm {
namespace {

constexpr Nanoseconds kMaxSimulationStep = 500'000;
constexpr Nanoseconds kMaxSimulatedAdvance = 10'000'000;

// Returns x shrunk towards 0 by threshold >= 0.
double SoftThreshold(double x, double threshold) {
  return std::copysign(std::max(std::abs(x) - threshold, 0.0), x);
}

}  // namespace

SimDevice::SimDevice(const DeviceProfile& profile, const ImpulseEngineKinematics& kinematics,
                     std::unique_ptr<Hand> hand)
    : kinematics_(kinematics),
      hand_(std::move(hand)),
      inertia_(AxesOf(profile).inertia),
      damping_(AxesOf(profile).damping),
      friction_(AxesOf(profile).friction),
      max_effort_(profile.max_torque, profile.max_torque, profile.max_force),
      intent_(hand_->At(0)),
      joints_(kinematics_.Inverse(intent_.p_W, intent_.roll, intent_.jaw).joints) {
  if (!((inertia_.array() > 0).all() && (damping_.array() >= 0).all() &&
        (friction_.array() >= 0).all())) {
    throw InputError(
        "instrument.device: mass, inertia, damping or friction: the device cannot move; give "
        "positive inertias and no negative damping or friction");
  }
}

std::unique_ptr<Device> SimDevice::Clone() const {
  auto copy = std::make_unique<SimDevice>(*this);
  if (!copy->hand_) return nullptr;
  return copy;
}

DeviceSample SimDevice::Read(Nanoseconds now) noexcept {
  if (reads_ > 0) {
    const Nanoseconds advance =
        std::clamp<Nanoseconds>(now - last_read_ns_, 0, kMaxSimulatedAdvance);
    const Nanoseconds steps = (advance + kMaxSimulationStep - 1) / kMaxSimulationStep;
    for (Nanoseconds i = 0; i < steps; ++i) {
      Step(advance * (i + 1) / steps - advance * i / steps);
    }
  }
  last_read_ns_ = now;
  return {
      .sequence = ++reads_, .time_ns = now, .joints = kinematics_.Quantise(joints_), .valid = true};
}

void SimDevice::Write(const AxisEffort& effort) noexcept {
  for (int i = 0; i < 3; ++i) {
    effort_[i] =
        std::isfinite(effort[i]) ? std::clamp(effort[i], -max_effort_[i], max_effort_[i]) : 0;
  }
}

void SimDevice::Home() noexcept {
  effort_.setZero();
  force_.Home();
}

void SimDevice::Step(Nanoseconds step_ns) noexcept {
  const double h = ToSeconds(step_ns);
  hand_time_ns_ += step_ns;
  intent_ = hand_->At(hand_time_ns_);

  const double K = hand_->stiffness(), B = hand_->damping();
  const Matrix3d J = kinematics_.Jacobian(joints_);
  const Vector3d p = kinematics_.Forward(joints_).translation();
  const Vector3d effort = force_.On() ? effort_ : Vector3d::Zero();
  // The hand's pull without the part that depends on the unknown velocity.
  const Vector3d pull = J.transpose() * (K * (intent_.p_W - p) + B * intent_.v_W) + effort;
  const DeviceLimits& limits = kinematics_.limits();
  for (int i = 0; i < 3; ++i) {
    const double g = J.col(i).squaredNorm();
    const double momentum = inertia_[i] * velocity_[i] + h * pull[i];
    const double effective_inertia = inertia_[i] + h * (damping_[i] + B * g) + h * h * K * g;
    const double free = SoftThreshold(momentum, h * friction_[i]) / effective_inertia;
    const double lowest = (limits.min_joints[i] - joints_[i]) / h;
    const double highest = (limits.max_joints[i] - joints_[i]) / h;
    velocity_[i] = std::clamp(free, lowest, highest);
    joints_[i] =
        std::clamp(joints_[i] + h * velocity_[i], limits.min_joints[i], limits.max_joints[i]);
  }
  joints_[kRoll] = std::clamp(intent_.roll, limits.min_joints[kRoll], limits.max_joints[kRoll]);
  joints_[kJaw] = std::clamp(intent_.jaw, 0.0, 1.0);
}

double SimDevice::Energy() const {
  const Vector3d stretch = intent_.p_W - kinematics_.Forward(joints_).translation();
  return 0.5 * velocity_.cwiseAbs2().dot(inertia_) +
         0.5 * hand_->stiffness() * stretch.squaredNorm();
}

}  // namespace hpdm
