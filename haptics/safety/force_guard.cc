#include "haptics/safety/force_guard.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

// Returns the factor <= 1 that brings the force within the device's limits.
double ScaleWithin(const ForceGuardOptions& options, const Vector3d& force, const Matrix3d& J) {
  // stableNorm: a huge input must be clamped, not overflow to infinity.
  double scale = 1;
  const auto limit = [&](double value, double bound) {
    if (value > bound) scale = std::min(scale, bound / value);
  };
  limit(force.stableNorm(), options.max_force);
  const Vector3d effort = J.transpose() * force;
  limit(std::abs(effort[kPitch]), options.max_torque);
  limit(std::abs(effort[kYaw]), options.max_torque);
  limit(std::abs(effort[kInsertion]), options.max_force);
  return scale;
}

}  // namespace

ForceGuard::Output ForceGuard::Filter(const Input& input) noexcept {
  Output output;
  if (!input.force_on) {
    Release();
    output.flags = kGuardDisabled;
    return output;
  }

  double scale = 1;
  if (input.reaction_W.allFinite()) {
    scale = ScaleWithin(options_, input.reaction_W, input.J);
    if (scale < 1) output.flags |= kGuardClamped;
    last_finite_ = scale * input.reaction_W;
  } else {
    output.flags |= kGuardNotFinite;
  }
  if (!input.has_patch || input.patch_age_ns > options_.stale_age_ns) {
    output.flags |= kGuardStalePatch;
  }
  if (!input.device_valid) output.flags |= kGuardDeviceInvalid;

  if (input.paused) output.flags |= kGuardPaused;

  constexpr std::uint32_t kFaults =
      kGuardNotFinite | kGuardStalePatch | kGuardDeviceInvalid | kGuardPaused;
  if ((output.flags & kFaults) != 0) {
    gain_ *= std::exp(-std::max(options_.period, input.elapsed) / options_.decay_time);
  } else if (gain_ < 1) {
    output.flags |= kGuardRampIn;
    gain_ = std::min(1.0, gain_ + options_.period / options_.ramp_in);
  }

  const Vector3d step = gain_ * last_finite_ - force_;
  const double longest = options_.max_force_rate * options_.period;
  const double length = step.norm();
  if (length > longest) {
    output.flags |= kGuardSlewed;
    force_ += (longest / length) * step;
  } else {
    force_ += step;
  }
  output.force_W = force_;
  output.authority = scale * gain_;
  return output;
}

ForceGuard::Output ForceGuard::RampOut(double share, bool force_on) noexcept {
  Output output;
  if (!force_on) output.flags = kGuardDisabled;
  if (!force_on || share <= 0) Release();
  output.force_W = share * force_;
  return output;
}

void ForceGuard::Release() noexcept {
  gain_ = 0;
  last_finite_.setZero();
  force_.setZero();
}

}  // namespace hpdm
