#pragma once

#include <algorithm>
#include <array>
#include <vector>

#include "haptics/safety/passivity.h"

namespace hpdm {

/// Greatest stiffness of a virtual wall that a device displays at its tip, N/m.
struct WallLimit {
  double stability = 0;  ///< Without a hand, with the passivity controller where it is on.
  double friction = 0;   ///< 2 f_c / encoder step, both at the tip; infinite without encoder step.

  /// The stiffness of a rigid organ: half of the stability limit, a gain margin of two, and at most
  /// the limit by friction.
  double Stiffness() const { return std::min(0.5 * stability, friction); }
};

/// The limits of one device for any direction of the wall and any lever of its tip.
///
/// 1. Axis i alone is stable up to K_i: StabilityLimit() with the controller's FullDamping() as a
///    sampled damper. The damping depends on the lever, so K_i is tabulated over it.
/// 2. The columns of J are orthogonal. A wall of stiffness k and unit normal n couples the axes by
///    k J^T n n^T J. With c_i = n . J_i they are stable together while
///        k sum_i c_i^2 / K_i < 1.
///    This is exact where damping dominates; 1/k is then additive over the directions.
/// 3. A motion of the tip along n turns axis i by c_i / g_i, with g_i the squared length of J_i. Its
///    friction is sum f_i |c_i| / g_i, and the encoders' step along n is sum step_i |c_i|.
/// 4. For every direction at once: the least over the axes of K_i / g_i and of 2 f_i / (g_i step_i).
class WallLimits {
 public:
  /// `passivity` with the loop's period; `delay` in s, in addition to the hold. Levers from
  /// `shortest` to `longest` (m, above 0); beyond them the nearest counts. Set-up: allocates.
  WallLimits(const PassivityOptions& passivity, double delay, double shortest, double longest);

  /// Limit along the unit vector normal_W for a tip with the Jacobian J (impulse_engine.h).
  WallLimit Along(const Matrix3d& J, const Vector3d& normal_W) const;
  /// Limit along the direction in which it is least.
  WallLimit InEveryDirection(const Matrix3d& J) const;

 private:
  double AxisStability(int axis, double arm) const;

  DeviceAxes device_;
  double shortest_, longest_;
  std::array<std::vector<double>, 3> stability_;  // K_i over the arm, equally spaced
};

}  // namespace hpdm
