#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"
#include "haptics/device/device_axes.h"

namespace hpdm {

struct PassivityOptions {
  bool control = true;  ///< If false, energy is only observed.
  /// Nothing drives organs: but for that of free organs, all energy in tissue is the hands'.
  bool still = true;
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
  double max_force_rate = 2000;  ///< N/s: the guard's slew limit.
};

/// Returns the controller's full damping of one axis, in the axis' own unit: the lesser of
/// 1. half of inertia / lag. The lag is half the velocity's `span` (s) plus half a period plus the
///    `age` of the samples (s); a damper with that lag alone is stable up to pi/2 inertia / lag;
/// 2. the damping at which one encoder count changes the force by `ripple`.
/// `arm`: length of the axis' column of J.
double FullDamping(const PassivityOptions& options, int axis, double arm, double span, double age);

/// A press on a rigid organ's virtual wall in one tick.
struct WallPress {
  double stored = 0;                          ///< Energy of the wall's springs, J; 0: no press.
  Vector3d reaction_W = Vector3d::Zero();     ///< The wall's part of the tissue's force, N.
  Vector3d p_tip_organ_W = Vector3d::Zero();  ///< The tip relative to the organ's motion, m.
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
/// the one before. It is in energy(), for the log, but is not damped. The energy tank limits the
/// latter (energy_tank.h).
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
/// 5. The full damping of an axis is FullDamping().
/// 6. There is no damping in free motion. The account is reset while the forces are off.
///
/// Virtual walls. A fast blow on a stiff wall generates more than any damping can dissipate before
/// the tip has left it: 11 mJ at 8 kN/m and 0.5 m/s, by the hold and the guard's slew limit. The
/// wall therefore returns at most the energy E that the hand has put into it:
/// 1. E is the hand's work on the displayed force since the contact began, relative to the organ's
///    own motion, plus the device's dissipation (as above) and `reserve`. Its work on soft tissue
///    that the same tip touches, and on the trocar, is subtracted. E is at most the energy U that the wall's springs
///    store, plus `reserve`.
/// 2. The wall's reaction F is scaled down to F sqrt(E / U), if that is less: springs that store E.
/// 3. While the tip moves out with the speed v, two bounds take the delay of the display into
///    account. With the wall's stiffness K, the lesser of F^2 / 2U and max_force_rate / v,
///        |F| <= sqrt(2 E K) - K v (period + age).
///    The first term lets the guard end the force before E is spent.
/// A wall whose stiffness differs from place to place is passive for the same reason.
/// The guard (force_guard.h) follows: it clamps, ramps and slews the damping with the rest of the
/// force. The observer then takes the guard's result.
///
/// Haptic thread; wait-free, no allocation, never throws.
class PassivityControl {
 public:
  explicit PassivityControl(const PassivityOptions& options);

  /// Call before the guard. Takes the device's sample, read at session time `now`. Returns the
  /// force (N) to add to the reaction: the damping, which is zero unless an axis has generated
  /// energy, and the part of a wall's reaction that exceeds its energy, taken away. `J`: d p_tip_W
  /// / d (pitch, yaw, insertion); `reaction_W`: the tissue's force on the hand; `friction_W`: that
  /// of the trocar, which the result includes and which is never damped in free motion.
  Vector3d Damp(Nanoseconds now, const DeviceSample& sample, const Vector3d& p_tip_W,
                const Matrix3d& J, const Vector3d& reaction_W, const WallPress& wall = {},
                const Vector3d& friction_W = Vector3d::Zero()) noexcept;

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
  double WallShare(const WallPress& wall) const;
  double Age() const;
  double Consumed(int axis, double dq, double dt) const;
  void SettleWall(const WallPress& wall);

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

  // The present press on a wall.
  struct Wall {
    bool presses = false;
    Nanoseconds sample_ns = 0;  // of the newest sample in `energy`
    Vector3d q = Vector3d::Zero();
    Vector3d p_tip_organ_W = Vector3d::Zero();
    Vector3d v_W = Vector3d::Zero();     // of the tip between the last two samples
    Vector3d soft_W = Vector3d::Zero();  // the rest of the reaction at the newest sample
    double energy = 0;                   // E, J
  };
  Wall wall_;

  Vector3d account_;      // J, one per axis
  double authority_ = 1;  // of the guard in the last tick
  double energy_ = 0;
  double damping_ = 0;
};

}  // namespace hpdm
