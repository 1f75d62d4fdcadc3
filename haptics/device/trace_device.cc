#include "haptics/device/trace_device.h"

#include <algorithm>
#include <cmath>

#include "engine/base/check.h"

namespace hpdm {

TraceMapping Fitted(TraceMapping mapping, const TraceMotion& motion, const Vector3d& p_deepest_W,
                    const Vector3d& normal_W) {
  mapping.position_W.setZero();
  Vector3d deepest = mapping.Apply(motion.places().front().values);
  for (const TraceMotion::Places::Knot& knot : motion.places()) {
    const Vector3d p = mapping.Apply(knot.values);
    if ((p - deepest).dot(normal_W) < 0) deepest = p;
  }
  mapping.position_W = p_deepest_W - deepest;
  return mapping;
}

TraceDevice::TraceDevice(const TraceFile& file, const TraceMotion& motion,
                         const TraceMapping& mapping, const ImpulseEngineKinematics& kinematics)
    : place_(file.place),
      motion_(std::make_shared<const TraceMotion>(motion)),
      mapping_(mapping),
      kinematics_(kinematics) {
  HPDM_CHECK(mapping.speed > 0);
}

DeviceSample TraceDevice::Read(Nanoseconds now) noexcept {
  if (!started_) start_ns_ = now;
  started_ = true;
  // Keeps times exact at the recorded speed.
  const Nanoseconds elapsed = now - start_ns_;
  const Nanoseconds time =
      mapping_.speed == 1
          ? elapsed
          : static_cast<Nanoseconds>(std::min(mapping_.speed * static_cast<double>(elapsed), 9e18));
  return {.sequence = ++reads_,
          .time_ns = now,
          .joints = Joints(motion_->At(time, &cursor_)).joints,
          .valid = true};
}

void TraceDevice::Home() noexcept {
  force_.Home();
  started_ = false;
  cursor_ = {};
}

Nanoseconds TraceDevice::duration() const {
  return std::llround(static_cast<double>(motion_->duration()) / mapping_.speed);
}

double TraceDevice::ClampedShare() const {
  const auto& places = motion_->places();
  const auto clamped = std::count_if(places.begin(), places.end(), [&](const auto& knot) {
    JointVector values;
    values << knot.values, 0, 1;
    return !Joints(values).reachable;
  });
  return static_cast<double>(clamped) / static_cast<double>(places.size());
}

ImpulseEngineKinematics::InverseResult TraceDevice::Joints(
    const JointVector& values) const noexcept {
  if (place_ != TracePlace::kJoints) {
    return kinematics_.Inverse(mapping_.Apply(values.head<3>()), values[kRoll], values[kJaw]);
  }
  const DeviceLimits& limits = kinematics_.limits();
  ImpulseEngineKinematics::InverseResult result;
  result.joints = values.cwiseMax(limits.min_joints).cwiseMin(limits.max_joints);
  result.reachable = result.joints == values;
  return result;
}

}  // namespace hpdm
