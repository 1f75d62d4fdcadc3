#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"
#include "haptics/device/device_axes.h"

namespace hpdm {

struct PassivityOptions {
  bool control = true;             ///< If false, energy is only observed.
  DeviceAxes device = AxesOf({});  ///< The device's own dissipation and inertia.
  double period = 1e-3;            ///< s, haptic period.

  /// Fraction of the device's own damping and friction that is relied on. A device's figures are
  /// seldom known to better than a factor of two.
  double device_share = 0.5;
  double reserve = 2e-6;  ///< J that an axis may generate undamped: a mass of 0.1 kg at 6 mm/s.
  double full = 4e-6;     ///< J beyond the reserve at which the damping is full.
  double pay = 5e-3;      ///< s, shortest time in which an axis dissipates its debt.
  double debt = 1e-3;     ///< J, largest debt of an axis.
  double leak = 1;        ///< s, time constant with which the account returns to the reserve.
  double window = 3e-3;   ///< s, over which the damped velocity is measured.
  double ripple = 0.1;    ///< N: largest change of the full damping's force by one encoder count,
                          ///< about the least that a hand feels.
};

/// Keeps the force that is displayed through one tool passive: a passivity observer and controller
/// in the time domain (Hannaford and Ryu 2002). The reference is the force that the tissue computed
/// (as in Ryu, Preusche, Hannaford and Hirzinger 2005).
///
/// Observer:
/// 1. The displayed force is constant from Write to Write. The hand's work between two device
///    samples is exactly
///        -F_held . (p_(k+1) - p_k),
///    and known at the next tick.
/// 2. Motion and force are matched by time: a sample that arrives late (DeviceSample::time_ns) is
///    paired with the force displayed then. The energy that a delay generates is thus included.
/// 3. energy() is the sum since the forces were switched on.
///
/// Generated energy. The sum alone would react late. Energy stored in a pressed spring or consumed
/// by friction in the tissue hides the energy that hold and delay generate. The controller
/// compares, on each axis, the displayed effort tau with the tissue's efforts e at the ends of the
/// motion dq:
///     generated = (tau_held - (e_k + e_(k+1)) / 2) dq.
/// For a linear spring it is 0 without hold and delay, and K dq^2 / 2 with the hold. It does not
/// depend on the energy that the tissue stores, dissipates or adds (breathing). The device consumes
///     device_share (b dq'^2 dt + f_c |dq|),
/// so a contact below half the passivity bound of stability.h is never damped.
///
/// The tissue's law itself also gives the hand energy, by breathing or by a patch that differs from
/// the one before. It is in energy(), for the log, but is not damped. Either it is intended, or its
/// source needs correction.
///
/// Controller. Each axis has an account, J:
/// 1. It starts at `reserve`. The device's dissipation adds to it, generated energy subtracts.
/// 2. It stays between -debt and `reserve`, so that neither a past surplus nor a single blow counts
///    for long. It returns to `reserve` with the time constant `leak`, so an axis that generates
///    less than reserve / leak, 2 uW, is not damped.
/// 3. Below 0 the axis is damped in proportion, from none at 0 to full at -full. Without a step
///    there is no chatter.
/// 4. The damping dissipates at most the debt over `pay`; in Hannaford and Ryu's rule it is over
///    one period. So a fast motion in soft tissue is not braked for a small debt.
/// 5. The full damping of an axis is the lesser of
///    - half of inertia / lag. The lag is half the velocity's window plus half a period plus the
///      age of the samples; a damper with that lag alone is stable up to pi/2 inertia / lag;
///    - the damping at which one encoder count changes the force by `ripple`.
/// 6. There is no damping in free motion. The account is reset while the forces are off.
///
/// The guard (force_guard.h) follows: it clamps, ramps and slews the damping with the rest of the
/// force. The observer then takes the guard's result.
///
/// Haptic thread; wait-free, no allocation, never throws.
class PassivityControl {
 public:
  explicit PassivityControl(const PassivityOptions& options);

  /// Call before the guard. Takes the device's sample, read at session time `now`. Returns the
  /// damping force on the hand (N), which is zero unless an axis has generated energy. `J`: d
  /// p_tip_W / d (pitch, yaw, insertion); `reaction_W`: the tissue's force on the hand.
  Vector3d Damp(Nanoseconds now, const DeviceSample& sample, const Vector3d& p_tip_W,
                const Matrix3d& J, const Vector3d& reaction_W) noexcept;

  /// Call after the guard. `force_W` is displayed from the `now` of Damp(). `authority` is the
  /// fraction of the reaction that the guard passes (ForceGuard::Output). `force_on`: the device
  /// displays the force.
  void Observe(const Vector3d& force_W, double authority, bool force_on) noexcept;

  /// Work of the hand since the forces were switched on, J; negative: the hand received energy.
  double energy() const { return energy_; }
  /// Damping at the tip on the most damped axis, N s/m; 0 without damping.
  double damping() const { return damping_; }

 private:
  // Longest delay that is matched, in periods. Older samples are ignored.
  static constexpr int kHistory = 64;

  // Force and device sample of one tick.
  struct Tick {
    Nanoseconds written_ns = 0;  // time from which force_W is displayed
    Nanoseconds sample_ns = 0;
    Vector3d q = Vector3d::Zero();  // pitch, yaw, insertion
    Vector3d force_W = Vector3d::Zero();
    AxisEffort effort = AxisEffort::Zero();
  };
  // Mean displayed force between two times.
  struct Held {
    Vector3d force_W = Vector3d::Zero();
    AxisEffort effort = AxisEffort::Zero();
    bool known = false;
  };

  // A sample whose motion is included in the energy balance.
  struct Judged {
    bool valid = false;
    Nanoseconds sample_ns = 0;
    Vector3d q = Vector3d::Zero();
    Vector3d p_tip_W = Vector3d::Zero();
    AxisEffort asked = AxisEffort::Zero();  // e
  };

  const Tick& Back(int ticks) const { return history_[(newest_ + kHistory - ticks) % kHistory]; }
  Held HeldBetween(Nanoseconds from_ns, Nanoseconds to_ns) const;
  void MeasureVelocity();
  void Settle(const Judged& before);

  PassivityOptions options_;
  Nanoseconds window_ns_;
  std::array<Tick, kHistory> history_;
  int newest_ = 0;
  int count_ = 0;

  // Inputs of the present tick.
  Nanoseconds now_ns_ = 0;
  DeviceSample sample_;
  Vector3d p_tip_W_ = Vector3d::Zero();
  Matrix3d J_ = Matrix3d::Zero();
  Vector3d reaction_W_ = Vector3d::Zero();
  Vector3d velocity_ = Vector3d::Zero();  // of the axes, measured over span_
  double span_ = 0;                       // s

  Judged judged_;  // the newest

  Vector3d account_;  // J, one per axis
  double energy_ = 0;
  double damping_ = 0;
};

}  // namespace hpdm
