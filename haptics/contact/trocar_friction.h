#pragma once

#include "haptics/safety/passivity.h"

namespace hpdm {

/// Coulomb friction of an instrument in its trocar, felt by the hand.
struct TrocarFrictionOptions {
  double force = 0;   ///< N, along the shaft; 0: none.
  double torque = 0;  ///< N m, about the pivot; 0: none.
  double delay = 0;   ///< s, from a reading to the force that answers it, in addition to the hold.
};

/// Computes the efforts of that friction in the tick (Hayward and Armstrong 2000).
///
/// Springs tie the insertion, and pitch and yaw together, to a point that the axes drag along:
/// while a spring would exceed the friction, its point follows at the distance of the friction over
/// the stiffness. So there is no sign of a velocity to be quantised, an axis at rest stays at rest,
/// and the work that goes in is dissipated but for the springs' own energy.
///
/// The springs have half of the stiffness that the device displays passively in any hand
/// (PassivityBound): what the hold, the encoders and the delay generate is less than half of what
/// the device dissipates. A device without damping therefore displays none.
///
/// Haptic thread; wait-free, no allocation, never throws.
class TrocarFriction {
 public:
  TrocarFriction(const TrocarFrictionOptions& options, const PassivityOptions& passivity);

  bool IsOn() const { return options_.force > 0 || options_.torque > 0; }

  /// Returns the efforts on the hand with the axes at `q`: pitch, yaw (rad) and insertion (m).
  AxisEffort Effort(const Vector3d& q) noexcept;

 private:
  TrocarFrictionOptions options_;
  double pivot_stiffness_ = 0;  // N m/rad
  double shaft_stiffness_ = 0;  // N/m
  bool started_ = false;
  Vector3d dragged_ = Vector3d::Zero();  // the springs' other ends
};

}  // namespace hpdm
