#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"
#include "haptics/device/device_axes.h"

namespace hpdm {

struct PassivityOptions {
  bool control = true;             ///< Off: the energy is observed, and nothing is added.
  DeviceAxes device = AxesOf({});  ///< What the device itself dissipates, and what it carries.
  double period = 1e-3;            ///< s, of the haptic loop.

  /// Part of the device's own damping and friction that is counted on: the figures of a device are
  /// seldom known to better than a factor of two.
  double device_share = 0.5;
  double reserve = 2e-6;  ///< J that an axis may generate unanswered: a mass of 0.1 kg at 6 mm/s.
  double full = 4e-6;     ///< J beyond the reserve at which the damping is full.
  double pay = 5e-3;      ///< s, in which an axis pays what it owes, or longer.
  double debt = 1e-3;     ///< J, the most that is held against an axis.
  double leak = 1;        ///< s, time constant with which all of that is forgotten.
  double window = 3e-3;   ///< s, over which the velocity that is damped is measured.
  double ripple = 0.1;    ///< N: one encoder count more in the window changes the full damping's
                          ///< force by no more than this, about the least that a hand feels.
};

/// Keeps the force that is displayed through one tool passive: a passivity observer and controller
/// in the time domain (Hannaford and Ryu 2002), with the force that the tissue computed as the
/// reference (as in Ryu, Preusche, Hannaford and Hirzinger 2005).
///
/// Observer. The displayed force is constant from Write to Write, so the work that the hand puts
/// in while the tip moves from one device sample to the next is exactly
///     -F_held . (p_(k+1) - p_k),
/// known at the next tick without error. Motion and force are matched by time: of a sample that is
/// old when it arrives (DeviceSample::time_ns) the force counts that was displayed then, so the
/// energy which a delay generates is seen. energy() is the sum since the forces were switched on.
///
/// That sum alone would answer late: what a pressed spring stores, and what friction in the tissue
/// has consumed, hide what holding and delaying the force generate. So the controller compares, on
/// each axis of the device, the work of the displayed effort tau with that of the effort e which
/// the tissue asked for at the two ends of the same motion dq:
///     generated = (tau_held - (e_k + e_(k+1)) / 2) dq.
/// For a linear spring without hold and delay it is zero, whatever the tissue stores, dissipates or
/// does by itself (breathing), and with the hold K dq^2 / 2. The device consumes
/// device_share (b dq'^2 dt + f_c |dq|) of it, so that a contact of less than half the
/// passivity bound of stability.h is never damped, however it is moved.
///
/// What that law itself gives the hand (breathing; a patch that differs from the one before) is in
/// energy(), for the log, and is not damped: it is meant to be felt, or to be put right where it
/// comes from.
///
/// Controller. Each axis has an account that starts at `reserve`, takes in what the device
/// consumes and pays what is generated. It never rises above `reserve` (surplus of the past must
/// not hide what comes) nor falls below -debt (one blow must not be held against it for long), and
/// returns to `reserve` with the time constant `leak` (an axis that generates less than reserve /
/// leak, 2 uW, is left alone). Overdrawn, it turns into damping in proportion, from none at 0 to
/// all at -full: no step, so nothing to chatter about. Nor is more dissipated than is owed, over
/// `pay` (Hannaford and Ryu's own rule, over one period), so that a fast motion in soft tissue is
/// not braked for a trifle. The full damping of an axis is the lesser of
///  - half of inertia / lag, where the lag is half the velocity's window, half a period and the age
///    of the samples: a damper with that lag alone is stable up to pi/2 inertia / lag;
///  - `ripple`: the encoder's steps must not be felt as a rattle.
/// There is no damping in free motion. The account is settled anew when the forces are off.
///
/// Stands before the guard (force_guard.h), which clamps, ramps and slews the damping with the rest
/// and so stays the last word on what is displayed; the observer then takes what came out of it.
///
/// Haptic thread; wait-free, no allocation, never throws.
class PassivityControl {
 public:
  explicit PassivityControl(const PassivityOptions& options);

  /// Before the guard. Takes the device's sample, read at session time `now`, and returns the
  /// damping force on the hand (N), which is zero unless an axis has generated energy.
  /// `J`: d p_tip_W / d (pitch, yaw, insertion); `reaction_W`: the tissue's force on the hand.
  Vector3d Damp(Nanoseconds now, const DeviceSample& sample, const Vector3d& p_tip_W,
                const Matrix3d& J, const Vector3d& reaction_W) noexcept;

  /// After the guard. `force_W` is displayed from the `now` of Damp() on; `authority` is the part
  /// of the reaction that the guard lets through (ForceGuard::Output); `force_on`: the device
  /// displays it.
  void Observe(const Vector3d& force_W, double authority, bool force_on) noexcept;

  /// J, that the hand has put in since the forces were switched on; negative: that it was given.
  double energy() const { return energy_; }
  /// N s/m at the tip, of the axis that is damped most; 0 when nothing is added.
  double damping() const { return damping_; }

 private:
  // As far back as a delay is matched: 64 periods. Older samples are not judged.
  static constexpr int kHistory = 64;

  // One tick.
  struct Tick {
    Nanoseconds written_ns = 0;  // when its force took over
    Nanoseconds sample_ns = 0;
    Vector3d q = Vector3d::Zero();  // pitch, yaw, insertion
    Vector3d force_W = Vector3d::Zero();
    AxisEffort effort = AxisEffort::Zero();
  };
  // Of the displayed force between two times, on average.
  struct Held {
    Vector3d force_W = Vector3d::Zero();
    AxisEffort effort = AxisEffort::Zero();
    bool known = false;
  };

  // A sample whose motion is accounted for.
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

  // Of the tick under way.
  Nanoseconds now_ns_ = 0;
  DeviceSample sample_;
  Vector3d p_tip_W_ = Vector3d::Zero();
  Matrix3d J_ = Matrix3d::Zero();
  Vector3d reaction_W_ = Vector3d::Zero();
  Vector3d velocity_ = Vector3d::Zero();  // of the axes,
  double span_ = 0;                       // over that many seconds

  Judged judged_;  // the newest

  Vector3d account_;  // J, of each axis
  double energy_ = 0;
  double damping_ = 0;
};

}  // namespace hpdm
