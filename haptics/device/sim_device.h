#pragma once

#include <memory>

#include "engine/base/copying.h"
#include "haptics/device/hand.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/device/instrument_options.h"
#include "haptics/device/switched_device.h"

namespace hpdm {

/// Simulates the Laparoscopic Impulse Engine in a hand that follows a script or a mouse.
///
/// On each actuated axis q_i (pitch, yaw, insertion), with constant inertia m_i, viscous damping
/// b_i and Coulomb friction f_i from the profile,
///
///     m_i q_i'' = tau_i + J_i^T F_hand - b_i q_i' - f_i sign(q_i'),
///     F_hand = K (p* - p) + B (p*' - p'),
///
/// with tau the written effort, held from Write to Write and saturated at the axis limits, and p*
/// the hand's intent for the tip's centre. Roll and jaw have no actuator: they follow the hand. The
/// trocar has no friction; the inertia coupling between the axes is neglected.
///
/// 1. Sub-steps of at most 0.5 ms use the velocity at their end (implicit Euler in K, B and b),
///    which is stable for any hand.
/// 2. The columns of J are orthogonal and the hand's impedance is isotropic, so the axes separate.
///    Each axis is a scalar problem, solved exactly.
/// 3. Friction is a soft threshold on the momentum: it holds an axis at exactly zero velocity and
///    cannot chatter. A workspace stop is a bound on the velocity (inelastic).
/// 4. Each Read advances by the time since the last one, virtual or real, by at most 10 ms. After a
///    longer gap the hand continues from its last state.
class SimDevice : public SwitchedDevice {
 public:
  /// Throws InputError if an inertia is not positive or a damping or friction is negative.
  SimDevice(const DeviceProfile& profile, const ImpulseEngineKinematics& kinematics,
            std::unique_ptr<Hand> hand);

  std::unique_ptr<Device> Clone() const override;
  DeviceSample Read(Nanoseconds now) noexcept override;
  void Write(const AxisEffort& effort) noexcept override;
  void Home() noexcept override;
  DeviceLimits limits() const noexcept override { return kinematics_.limits(); }

  /// The true joints, before the encoders. Owner.
  const JointVector& joints() const { return joints_; }
  /// Velocities of pitch, yaw (rad/s) and insertion (m/s). Owner.
  const Vector3d& axis_velocity() const { return velocity_; }
  /// Energy of the axes' motion and of the hand's spring, J. Owner.
  double Energy() const;

 private:
  void Step(Nanoseconds step_ns) noexcept;

  ImpulseEngineKinematics kinematics_;
  Cloned<Hand> hand_;
  Vector3d inertia_;   // kg m^2, kg m^2, kg
  Vector3d damping_;   // N m s/rad, N m s/rad, N s/m
  Vector3d friction_;  // N m, N m, N
  Vector3d max_effort_;

  AxisEffort effort_ = AxisEffort::Zero();
  HandIntent intent_;
  JointVector joints_;
  Vector3d velocity_ = Vector3d::Zero();
  Nanoseconds hand_time_ns_ = 0;
  Nanoseconds last_read_ns_ = 0;
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
