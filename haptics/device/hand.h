#pragma once

#include <memory>

#include "engine/base/types.h"

namespace hpdm {

/// Intended state of the instrument at an instant.
struct HandIntent {
  Vector3d p_W = Vector3d::Zero();  ///< Tip's centre, m, tremor included.
  Vector3d v_W = Vector3d::Zero();  ///< m/s.
  double roll = 0;                  ///< rad.
  double jaw = 1;                   ///< 0 closed .. 1 open.
};

/// The hand that holds the instrument of a SimDevice. It has an intent, and a constant impedance:
/// an isotropic spring and damper from the tip to the intent. Through it the displayed force moves
/// the hand. Call on the device's thread only.
class Hand {
 public:
  /// Stiffness in N/m, damping in N s/m. Throws InputError if one is negative or not finite.
  Hand(double stiffness, double damping);
  virtual ~Hand() = default;

  /// Returns a copy that continues from the same state; nullptr for a hand outside of the program.
  virtual std::unique_ptr<Hand> Clone() const { return nullptr; }

  /// Returns the intent at hand time t_ns >= 0. Times never decrease from call to call. Wait-free,
  /// no allocation.
  virtual HandIntent At(Nanoseconds t_ns) noexcept = 0;

  double stiffness() const { return stiffness_; }  ///< N/m.
  double damping() const { return damping_; }      ///< N s/m.

 private:
  double stiffness_;
  double damping_;
};

}  // namespace hpdm
