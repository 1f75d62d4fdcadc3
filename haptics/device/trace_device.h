#pragma once

#include <cstddef>
#include <vector>

#include "haptics/device/device.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/device/trace_motion.h"

namespace hpdm {

/// Where a trace's tips go in the world: p_W = position + scale R_WF p_F, with p_F as in the file.
struct TraceMapping {
  double scale = 1;  ///< m per unit of the file.
  Matrix3d R_WF = Matrix3d::Identity();
  Vector3d position_W = Vector3d::Zero();  ///< m: where the file's origin goes.
  double speed = 1;                        ///< Times as fast as recorded.

  Vector3d Apply(const Vector3d& p_F) const { return position_W + scale * (R_WF * p_F); }
};

/// `mapping` moved so that the place of the motion that lies deepest along -normal_W (the first of
/// them) goes to p_deepest_W: for a trace whose frame nothing is known of.
TraceMapping Fitted(TraceMapping mapping, const TraceMotion& motion, const Vector3d& p_deepest_W,
                    const Vector3d& normal_W);

/// Plays a recorded motion (trace_motion.h): the first Read after Home is the trace's start, and
/// after its end the last pose stands. A sample is taken at the time of its Read.
///
/// A trace is what happened: forces are computed, guarded and logged as for any device, but nothing
/// moves by them. Poses are as the file has them, without an encoder's steps. What the workspace
/// does not reach is clamped to it, joint by joint.
class TraceDevice : public Device {
 public:
  /// The mapping's place and scale act on traces of tips; a trace without a place stands at
  /// position_W. Its roll and jaw are the file's.
  TraceDevice(const TraceFile& file, const TraceMotion& motion, const TraceMapping& mapping,
              const ImpulseEngineKinematics& kinematics);

  DeviceSample Read(Nanoseconds now) noexcept override;
  /// Without effect on the motion.
  void Write(const AxisEffort&) noexcept override {}
  /// Back to the trace's start.
  void Home() noexcept override;
  void EnableForce(bool on) noexcept override { force_.Enable(on); }
  void EmergencyStop() noexcept override { force_.EmergencyStop(); }
  bool ForceOn() const noexcept override { return force_.On(); }
  DeviceLimits limits() const noexcept override { return kinematics_.limits(); }

  /// Time until the last pose, at the mapping's speed.
  Nanoseconds duration() const;
  /// Share of the places (rows that are no repeats), 0 to 1, that the workspace does not reach.
  double ClampedShare() const;

 private:
  ImpulseEngineKinematics::InverseResult Joints(const JointVector& values) const noexcept;

  TracePlace place_;
  TraceMotion motion_;
  TraceMapping mapping_;
  ImpulseEngineKinematics kinematics_;
  ForceSwitch force_;
  bool started_ = false;
  Nanoseconds start_ns_ = 0;
  TraceMotion::Cursor cursor_;
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
