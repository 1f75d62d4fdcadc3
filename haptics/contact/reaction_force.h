#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// Returns the force of a mass-spring node (Tseng, Lin, Lee, Eq. 29; N neighbours, so N terms).
/// With the displacement delta = p_current - p_original and l_i = p_current - p_i = edge_i + delta
/// the force on the TISSUE is
///
///     F(delta) = k1 delta + sum_i k2_i (|l_i| - d_i) / |l_i| l_i,
///
/// and the force on the HAND is -F. A spring's direction is undefined if its ends meet, so 1 /
/// |l_i| is replaced by 1 / max(|l_i|, d_i / 100). F is then continuous and finite, and exact for
/// every spring longer than a hundredth of its rest length.
///
/// delta_W in m, result in N, world axes. Any thread; wait-free, no allocation.
Vector3d ForceOnTissue(const ReactionNode& node, const Vector3d& delta_W) noexcept;

/// Returns -ForceOnTissue.
inline Vector3d ForceOnHand(const ReactionNode& node, const Vector3d& delta_W) noexcept {
  return -ForceOnTissue(node, delta_W);
}

/// Returns K = dF/d(delta) of ForceOnTissue, 3 x 3 symmetric, N/m:
///
///     K = k1 I + sum_i k2_i (I - d_i / |l_i| (I - u_i u_i^T)),   u_i = l_i / |l_i|.
///
/// A strongly shortened spring makes K indefinite (it buckles). Any thread; wait-free, no
/// allocation.
Matrix3d TissueStiffness(const ReactionNode& node, const Vector3d& delta_W) noexcept;

}  // namespace hpdm
