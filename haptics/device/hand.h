#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// What a hand means to do at an instant.
struct HandIntent {
  Vector3d p_W = Vector3d::Zero();  ///< Of the tip's centre, m, tremor included.
  Vector3d v_W = Vector3d::Zero();  ///< m/s.
  double roll = 0;                  ///< rad.
  double jaw = 1;                   ///< 0 closed .. 1 open.
};

/// Who holds the instrument of a SimDevice: an intent, and a constant impedance (an isotropic
/// spring and damper from the tip to the intent) through which the displayed force moves the hand.
/// One thread at a time: that of the device.
class Hand {
 public:
  /// N/m and N s/m. Throws InputError when one is negative or not finite.
  Hand(double stiffness, double damping);
  virtual ~Hand() = default;

  /// Intent at hand time t_ns >= 0. Times never decrease from call to call. Wait-free, no
  /// allocation.
  virtual HandIntent At(Nanoseconds t_ns) noexcept = 0;

  double stiffness() const { return stiffness_; }  ///< N/m.
  double damping() const { return damping_; }      ///< N s/m.

 private:
  double stiffness_;
  double damping_;
};

}  // namespace hpdm
