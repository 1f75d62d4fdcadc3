#pragma once

#include <memory>

#include "haptics/device/impulse_engine.h"
#include "haptics/device/switched_device.h"

namespace hpdm {

/// A device that a program moves: it moves at constant speed from where it is to each command, in
/// the time that the command gives, and then stands still. Joints beyond the workspace are put on
/// its border. The forces do not move it. One thread; wait-free.
class CommandDevice final : public SwitchedDevice {
 public:
  /// Starts at `joints`, without motion.
  CommandDevice(const ImpulseEngineKinematics& kinematics, const JointVector& joints);

  std::unique_ptr<Device> Clone() const override { return std::make_unique<CommandDevice>(*this); }

  /// Moves to `joints` (finite) between session times `now` and `now` + `duration` (above 0).
  void MoveTo(const JointVector& joints, Nanoseconds now, Nanoseconds duration) noexcept;
  /// Where the last command leads to.
  const JointVector& joints() const { return to_; }

  DeviceSample Read(Nanoseconds now) noexcept override;
  void Write(const AxisEffort& /*effort*/) noexcept override {}
  DeviceLimits limits() const noexcept override { return limits_; }

 private:
  JointVector At(Nanoseconds now) const noexcept;

  DeviceLimits limits_;
  JointVector from_, to_;
  Nanoseconds start_ns_ = 0;
  Nanoseconds duration_ns_ = 1;
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
