#include "tools/session/command_device.h"

#include <algorithm>

namespace hpdm {

CommandDevice::CommandDevice(const ImpulseEngineKinematics& kinematics, const JointVector& joints)
    : limits_(kinematics.limits()) {
  to_ = joints.cwiseMax(limits_.min_joints).cwiseMin(limits_.max_joints);
  from_ = to_;
}

void CommandDevice::MoveTo(const JointVector& joints, Nanoseconds now,
                           Nanoseconds duration) noexcept {
  from_ = At(now);
  to_ = joints.cwiseMax(limits_.min_joints).cwiseMin(limits_.max_joints);
  start_ns_ = now;
  duration_ns_ = std::max<Nanoseconds>(duration, 1);
}

JointVector CommandDevice::At(Nanoseconds now) const noexcept {
  const Nanoseconds elapsed = std::clamp<Nanoseconds>(now - start_ns_, 0, duration_ns_);
  if (elapsed == duration_ns_) return to_;
  const double share = static_cast<double>(elapsed) / static_cast<double>(duration_ns_);
  return from_ + share * (to_ - from_);
}

DeviceSample CommandDevice::Read(Nanoseconds now) noexcept {
  return {.sequence = ++reads_, .time_ns = now, .joints = At(now), .valid = true};
}

}  // namespace hpdm
