#pragma once

#include <cstdint>

#include "engine/snapshots.h"

namespace hpdm {

struct ForceGuardOptions {
  double max_force = 8.9;                ///< N, length of the force vector.
  double max_torque = 1.0;               ///< N m, on the pitch and on the yaw axis.
  double max_force_rate = 2000;          ///< N/s.
  double period = 1e-3;                  ///< s, of the haptic loop.
  double ramp_in = 0.5;                  ///< s, from no authority to full authority.
  double decay_time = 0.05;              ///< s, time constant of the loss of authority.
  Nanoseconds stale_age_ns = 133333333;  ///< Patch age beyond which the force decays: four
                                         ///< deformation periods at 30 Hz.
};

/// Makes one tool's force safe to display. Each tick, in this order:
///
///  1. Replace: the last finite force replaces a force that is not finite.
///  2. Clamp: the force is scaled, so that its direction is kept, to the device's force limit as a
///     vector and to its axis limits through J^T.
///  3. Authority: a gain in [0, 1] multiplies the force. It starts at 0 and rises linearly within
///     `ramp_in`. It falls exponentially with `decay_time` while the force is not finite, the patch
///     is stale or absent, the device is invalid or the session is paused.
///  4. Slew: the change from the last displayed force is limited to max_force_rate * period.
///
/// Reasons for the order and exceptions:
///
///  - Clamping before the gain bounds the start-up force by gain * max_force for any input.
///  - The slew limit is last, so no later stage can cause a step. Its result lies between the last
///    displayed force and the clamped one, both in the same ball, so it needs no second clamp.
///  - The axis limits form a set that turns with the tip. The device saturates an effort that the
///    slew limit leaves outside of it for a tick.
///  - After skipped ticks the gain falls by the elapsed time. It rises, and the force slews, only
///    as for one period. Each is the safe side.
///  - If the device's force is off (disabled, emergency stop, not homed) the motors have already
///    let go. The result is 0 at once, past the slew limit, and the start-up begins again.
///
/// Haptic thread; wait-free, no allocation, never throws.
class ForceGuard {
 public:
  explicit ForceGuard(const ForceGuardOptions& options) : options_(options) {}

  struct Input {
    Vector3d reaction_W = Vector3d::Zero();  ///< Force on the hand, N.
    Matrix3d J = Matrix3d::Zero();           ///< d p_tip_W / d (pitch, yaw, insertion).
    double elapsed = 0;                      ///< s since the last tick that ran.
    bool has_patch = false;
    Nanoseconds patch_age_ns = 0;
    bool device_valid = false;
    bool force_on = false;  ///< Device::ForceOn().
    bool paused = false;    ///< SessionControl::paused.
  };
  struct Output {
    Vector3d force_W = Vector3d::Zero();  ///< N, always finite.
    std::uint32_t flags = kGuardOk;       ///< GuardFlag, or-ed.
    double authority = 0;  ///< Fraction of the reaction that clamp and authority pass.
  };
  Output Filter(const Input& input) noexcept;

  /// Restarts the ramp-in from no authority. A force that is felt falls at the slew limit.
  void RampIn() noexcept { gain_ = 0; }

  /// Takes the force away at the end of a session. Displays the fraction `share` (1 to 0) of the
  /// force that the last Filter displayed; the contact plays no part. After 0 a Filter would ramp
  /// in.
  Output RampOut(double share, bool force_on) noexcept;

 private:
  void Release() noexcept;

  ForceGuardOptions options_;
  double gain_ = 0;
  Vector3d last_finite_ = Vector3d::Zero();  // clamped, before the gain
  Vector3d force_ = Vector3d::Zero();        // last displayed
};

}  // namespace hpdm
