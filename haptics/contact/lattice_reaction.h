#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// One tip at tissue with known compliance, in one tick (engine/README.md, section 4). A force F on
/// the tissue moves the contact point from its released position p_original to
///     p_current = p_original + C F (+ C_ac F_c of another tip c on the same organ).
/// Under a press C is the sum of `compliance_W` and the compliance q(f_n) H of the indentation,
/// which depends on the pressing force (LocalIndentation::BallYield).
struct CondensedTip {
  bool holds = false;                        ///< Grasp: the jaws carry the point to p_current.
  Vector3d p_original_W = Vector3d::Zero();  ///< m.
  Matrix3d compliance_W = Matrix3d::Zero();  ///< m/N, symmetric positive definite.
  LocalIndentation indentation = {};         ///< Press.
  Vector3d p_current_W = Vector3d::Zero();   ///< Grasp: m.
  Vector3d normal_W = Vector3d::Zero();      ///< Press: outward, unit.
  Vector3d friction_W = Vector3d::Zero();    ///< Press: tangential force on the tissue over f_n.
  double depth = 0;                          ///< Press: n . (p_original - x_tip) + r, m.
};

/// Returns C at the force F on the tissue (N), m/N.
Matrix3d ComplianceAt(const CondensedTip& tip, const Vector3d& force_W) noexcept;

/// Returns the energy that the contact's springs store at the force F on the tissue (N), J:
///     F . C F / 2 of `compliance_W`, and the integral of f d(f q) a . H a of the indentation.
/// The integral is within 1 %. Any thread; wait-free, no allocation.
double TipEnergy(const CondensedTip& tip, const Vector3d& force_W) noexcept;

/// Returns the force on the tissue by one tip alone, N:
///     press:  F = f_n a with a = friction - n,  f_n (-n^T C a) = max(0, depth);
///     grasp:  F = C^-1 delta.
/// The force of a press is a function of its depth alone, so it is conservative. Any thread;
/// wait-free, no allocation.
Vector3d TipForce(const CondensedTip& tip) noexcept;

/// Returns the force (N) that moves the pressed point by `moved_W` (m) from p_original: C F =
/// moved. It may pull. Any thread; wait-free, no allocation.
Vector3d HoldingForce(const CondensedTip& tip, const Vector3d& moved_W) noexcept;

/// Computes the forces of two tips on one organ, coupled by C_ac (`coupling_W`, m/N). Two presses
/// are a nonlinear complementarity problem in their f_n; a grasp is an equality. If the tissue hardly
/// distinguishes the tips and they move apart, slip compliance is added, as in the step
/// (ContactSolver). Any thread; wait-free, no allocation.
void TipForces(const CondensedTip& a, const CondensedTip& c, const Matrix3d& coupling_W,
               Vector3d* force_a_W, Vector3d* force_c_W) noexcept;

/// Returns S = C^-1 as a node of Eq. 29. The stiffness k1 is the smallest eigenvalue of S. Each of
/// the other two eigenvectors e has a neighbour p_original - L e at its rest length L. Its
/// stiffness k2 is the rest of the eigenvalue. A spring turns by delta / L as its end moves by
/// delta. With L = 1e10 m the force for 1 cm is exact to 1e-12. C must be positive definite. Any
/// thread; wait-free, no allocation.
ReactionNode NodeOfCompliance(const Matrix3d& C) noexcept;

}  // namespace hpdm
