#include "haptics/device/impulse_engine.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "engine/base/error.h"

namespace hpdm {
namespace {

Matrix3d HomeFrame(const Vector3d& home_direction) {
  const Vector3d z = home_direction.normalized();
  int least = 2;
  for (const int axis : {1, 0}) {
    if (std::abs(z[axis]) < std::abs(z[least])) least = axis;
  }
  const Vector3d up = Vector3d::Unit(least);
  const Vector3d y = (up - up.dot(z) * z).normalized();
  Matrix3d R;
  R << y.cross(z), y, z;
  return R;
}

}  // namespace

DeviceLimits LimitsOf(const DeviceProfile& profile) {
  DeviceLimits limits;
  limits.max_force = profile.max_force;
  limits.max_torque = profile.max_torque;
  limits.max_force_rate = profile.max_force_rate;
  const double angle = profile.max_angle;
  const double turn = 2 * std::numbers::pi;
  limits.min_joints << -angle, -angle, profile.min_insertion, -turn, 0;
  limits.max_joints << angle, angle, profile.max_insertion, turn, 1;
  limits.encoder_steps << profile.angle_encoder_step, profile.angle_encoder_step,
      profile.encoder_step, profile.angle_encoder_step, profile.jaw_encoder_step;
  return limits;
}

ImpulseEngineKinematics::ImpulseEngineKinematics(const Vector3d& p_trocar_W,
                                                 const Vector3d& home_direction_W,
                                                 const DeviceProfile& profile)
    : p_trocar_W_(p_trocar_W), limits_(LimitsOf(profile)) {
  if (!p_trocar_W.allFinite() || !home_direction_W.allFinite() ||
      !(home_direction_W.norm() > 1e-9)) {
    throw InputError(
        "instrument: trocar: the trocar coincides with its target; move the trocar "
        "away from it");
  }
  if (!(profile.max_angle > 0 && profile.max_angle < std::numbers::pi / 2)) {
    throw InputError(
        "instrument.device: max_angle: pitch is singular at pi/2; give an angle in rad "
        "between 0 and 1.57");
  }
  if (!(profile.min_insertion > 0 && profile.max_insertion > profile.min_insertion)) {
    throw InputError(
        "instrument.device: min_insertion: pitch and yaw are singular at the trocar; "
        "give 0 < min_insertion < max_insertion in m");
  }
  R_WH_ = HomeFrame(home_direction_W);
}

Isometry3d ImpulseEngineKinematics::Forward(const JointVector& joints) const {
  const double sp = std::sin(joints[kPitch]), cp = std::cos(joints[kPitch]);
  const double sy = std::sin(joints[kYaw]), cy = std::cos(joints[kYaw]);
  const double sr = std::sin(joints[kRoll]), cr = std::cos(joints[kRoll]);
  // R_y(yaw) R_x(pitch) R_x(pi), column by column; the third is -d in H.
  const Vector3d x(cy, 0, -sy), y(-sy * sp, -cp, -cy * sp), z(-cp * sy, sp, -cp * cy);
  Matrix3d R_HT;
  R_HT << cr * x + sr * y, cr * y - sr * x, z;
  Isometry3d X_WT;
  X_WT.linear() = R_WH_ * R_HT;
  X_WT.translation() = p_trocar_W_ - joints[kInsertion] * X_WT.linear().col(2);
  X_WT.makeAffine();
  return X_WT;
}

ImpulseEngineKinematics::InverseResult ImpulseEngineKinematics::Inverse(const Vector3d& p_tip_W,
                                                                        double roll,
                                                                        double jaw) const {
  const Vector3d v = R_WH_.transpose() * (p_tip_W - p_trocar_W_);
  JointVector wanted;
  // atan2(0, 0) is 0: the home direction at the trocar.
  wanted << std::atan2(-v.y(), std::hypot(v.x(), v.z())), std::atan2(v.x(), v.z()), v.norm(), roll,
      jaw;
  InverseResult result;
  result.joints = wanted.cwiseMax(limits_.min_joints).cwiseMin(limits_.max_joints);
  result.reachable = result.joints == wanted;
  return result;
}

Matrix3d ImpulseEngineKinematics::Jacobian(const JointVector& joints) const {
  const double sp = std::sin(joints[kPitch]), cp = std::cos(joints[kPitch]);
  const double sy = std::sin(joints[kYaw]), cy = std::cos(joints[kYaw]);
  const double rho = joints[kInsertion];
  Matrix3d J_H;
  J_H.col(0) = rho * Vector3d(-sp * sy, -cp, -sp * cy);
  J_H.col(1) = rho * Vector3d(cp * cy, 0, -cp * sy);
  J_H.col(2) = Vector3d(cp * sy, -sp, cp * cy);
  return R_WH_ * J_H;
}

JointVector ImpulseEngineKinematics::Quantise(const JointVector& joints) const {
  JointVector quantised = joints;
  for (int axis = 0; axis < joints.size(); ++axis) {
    const double step = limits_.encoder_steps[axis];
    if (step > 0) quantised[axis] = std::round(joints[axis] / step) * step;
  }
  return quantised;
}

}  // namespace hpdm
