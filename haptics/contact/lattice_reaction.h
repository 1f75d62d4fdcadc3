#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// One tip at tissue whose compliance is known, in one tick (engine/README.md, section 4).
/// With p_original where its point goes when all tips let go and C its compliance, forces F on the
/// tissue move it to
///     p_current = p_original + C F (+ C_ac F_c of another tip c on the same organ).
struct CondensedTip {
  bool holds = false;                        ///< Grasp: the jaws carry the point to p_current.
  Vector3d p_original_W = Vector3d::Zero();  ///< m.
  Matrix3d compliance_W = Matrix3d::Zero();  ///< C, m/N, symmetric positive definite.
  Vector3d p_current_W = Vector3d::Zero();   ///< Grasp: m.
  Vector3d normal_W = Vector3d::Zero();      ///< Press: outward, unit.
  Vector3d friction_W = Vector3d::Zero();    ///< Press: tangential force on the tissue over f_n.
  double depth =
      0;  ///< Press: of the tip under the released point, n . (p_original - x_tip) + r, m.
};

/// The forces on the tissue, N, of one tip alone:
///     press:  F = f_n a with a = friction - n,  f_n = max(0, depth / (-n^T C a));
///     grasp:  F = C^-1 delta.
/// Any thread; wait-free, no allocation.
Vector3d TipForce(const CondensedTip& tip) noexcept;

/// The forces of two tips on one organ, coupled by C_ac (`coupling_W`, m/N): two presses are a
/// complementarity problem in their f_n, and what jaws hold stays held while the other tip moves.
/// Tips that the tissue cannot tell apart slip when they go different ways, as in the step
/// (ContactSolver): each stays behind by a share of what its force moves it alone.
/// Any thread; wait-free, no allocation.
void TipForces(const CondensedTip& a, const CondensedTip& c, const Matrix3d& coupling_W,
               Vector3d* force_a_W, Vector3d* force_c_W) noexcept;

/// S = C^-1 as a node of Eq. 29: k1 is the smallest eigenvalue of S, and each of the other two
/// eigenvectors e carries a neighbour p_original - L e at its rest length L with the rest of its
/// eigenvalue. The neighbours are 1e10 m away: a spring turns by delta / L as its end moves by
/// delta, so at 1,000 m the force of 1 cm would be wrong by 1e-5, and here by 1e-12. C must be
/// positive definite. Any thread; wait-free, no allocation.
ReactionNode NodeOfCompliance(const Matrix3d& C) noexcept;

}  // namespace hpdm
