#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "haptics/device/impulse_engine.h"
#include "haptics/device/switched_device.h"
#include "haptics/device/trace_motion.h"

namespace hpdm {

/// Maps a trace's tips to the world: p_W = position + scale R_WF p_F, with p_F as in the file.
struct TraceMapping {
  double scale = 1;  ///< m per unit of the file.
  Matrix3d R_WF = Matrix3d::Identity();
  Vector3d position_W = Vector3d::Zero();  ///< World position of the file's origin, m.
  double speed = 1;                        ///< Playback speed over recorded speed.

  Vector3d Apply(const Vector3d& p_F) const { return position_W + scale * (R_WF * p_F); }
};

/// Returns `mapping` translated so that the first of the deepest places along -normal_W maps to
/// p_deepest_W. It is for traces in an unknown frame.
TraceMapping Fitted(TraceMapping mapping, const TraceMotion& motion, const Vector3d& p_deepest_W,
                    const Vector3d& normal_W);

/// Plays a recorded motion (trace_motion.h). The first Read after Home is the trace's start; after
/// its end the last pose is held. A sample is taken at the time of its Read.
///
/// Forces are computed, guarded and logged as for any device but do not move the instrument. Poses
/// are those of the file, without encoder steps. Poses beyond the workspace are clamped to it,
/// joint by joint.
class TraceDevice : public SwitchedDevice {
 public:
  /// The mapping's position, rotation and scale act on traces of tips. A trace without places stays
  /// at position_W. Roll and jaw come from the file.
  TraceDevice(const TraceFile& file, const TraceMotion& motion, const TraceMapping& mapping,
              const ImpulseEngineKinematics& kinematics);

  std::unique_ptr<Device> Clone() const override { return std::make_unique<TraceDevice>(*this); }
  DeviceSample Read(Nanoseconds now) noexcept override;
  /// Does nothing.
  void Write(const AxisEffort&) noexcept override {}
  /// Returns to the trace's start.
  void Home() noexcept override;
  DeviceLimits limits() const noexcept override { return kinematics_.limits(); }

  /// Time until the last pose, at the mapping's speed.
  Nanoseconds duration() const;
  /// Share of the places (rows without repeats) outside the workspace, 0 to 1.
  double ClampedShare() const;

 private:
  ImpulseEngineKinematics::InverseResult Joints(const JointVector& values) const noexcept;

  TracePlace place_;
  std::shared_ptr<const TraceMotion> motion_;  // copies share it
  TraceMapping mapping_;
  ImpulseEngineKinematics kinematics_;
  bool started_ = false;
  Nanoseconds start_ns_ = 0;
  TraceMotion::Cursor cursor_;
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
