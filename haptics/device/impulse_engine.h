#pragma once

#include "engine/snapshots.h"
#include "haptics/device/device.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Returns a profile's limits. Roll is unlimited but kept within a turn of zero.
DeviceLimits LimitsOf(const DeviceProfile& profile);

/// Kinematics of the Laparoscopic Impulse Engine: a gimbal about the trocar that carries a shaft.
///
/// The home frame H stands at the trocar with z_H = home direction h (into the body). Yaw turns
/// about y_H, then pitch about the gimbal's own x; the shaft leaves the trocar along
///
///     d(pitch, yaw) = R_WH (cos(pitch) sin(yaw), -sin(pitch), cos(pitch) cos(yaw)),
///
/// and the tip's centre is p = trocar + insertion d. The tool frame is
/// R_WT = R_WH R_y(yaw) R_x(pitch) R_x(pi) R_z(roll): z_T = -d, y_T the jaw's axis.
///
/// y_H is the world axis least aligned with h (z before y before x on a tie), made perpendicular
/// to h; x_H = y_H x z_H. Pitch = yaw = 0 lies on h. The only singularities, det J = -insertion^2
/// cos(pitch) = 0, are the trocar itself and pitch = +-pi/2. The workspace excludes both for any h
/// (min_insertion > 0 and max_angle < pi/2 are checked).
///
/// Constant after construction; every function is wait-free and allocates nothing.
class ImpulseEngineKinematics {
 public:
  /// p_trocar_W in m; home_direction_W from the trocar into the body, of any length. Throws
  /// InputError if the direction is zero or the profile's workspace contains a singularity.
  ImpulseEngineKinematics(const Vector3d& p_trocar_W, const Vector3d& home_direction_W,
                          const DeviceProfile& profile);

  /// Returns X_WT for any joints, inside the workspace or not; the jaw has no effect.
  Isometry3d Forward(const JointVector& joints) const;

  struct InverseResult {
    JointVector joints = JointVector::Zero();
    bool reachable = true;  ///< False if a joint was clamped to the workspace.
  };
  /// Returns the joints that place the tip's centre at p_tip_W with this roll (rad) and jaw (0..1).
  /// Outside the workspace each joint is clamped to its own limit. At the trocar, where the
  /// direction is undefined, it is the home direction.
  InverseResult Inverse(const Vector3d& p_tip_W, double roll, double jaw) const;

  /// Returns J = d p_tip_W / d (pitch, yaw, insertion), 3 x 3: m/rad, m/rad, 1. Its columns are
  /// orthogonal with squared lengths (insertion^2, insertion^2 cos^2(pitch), 1). The efforts
  /// J^T force_W display the force force_W (N) on the hand at the tip.
  Matrix3d Jacobian(const JointVector& joints) const;

  /// Rounds every axis to the nearest whole encoder step.
  JointVector Quantise(const JointVector& joints) const;

  const Vector3d& p_trocar_W() const { return p_trocar_W_; }
  const DeviceLimits& limits() const { return limits_; }

 private:
  Vector3d p_trocar_W_;
  Matrix3d R_WH_;
  DeviceLimits limits_;
};

}  // namespace hpdm
