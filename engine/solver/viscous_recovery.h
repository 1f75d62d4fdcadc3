#pragma once

#include "engine/solver/relaxation.h"

namespace hpdm {

/// Kelvin-Voigt tissue with the relaxation time tau, a damper tau K beside every spring, around any
/// relaxation:
///     K (U + tau dU/dt) = B^T f.
///
/// 1. A contact feels S (delta + tau d delta/dt). Released tissue recovers as exp(-t / tau).
/// 2. Over a step of length dt with constant forces the exact solution is
///        U(dt) = e U(0) + (1 - e) V,   K V = B^T f,   e = exp(-dt / tau)
///    with V the rest state of the same forces.
/// 3. So V is the relaxation under contacts with the changed target t and local compliance
///        t' = e U(0) + (t - e U(0)) / (1 - e),   C_loc' = C_loc / (1 - e)
///    with t and U(0) as displacements of the contact point.
/// 4. With a nonlinear energy V would need forces 1 / (1 - e) times those that the tissue feels.
///    The step then damps the energy itself, with K the stiffness at rest:
///        dE/dU + e / (1 - e) K (U - U(0)) = B^T f.
///    For a quadratic E this equals 2. Without contact U(dt) = e U(0) in both cases.
/// 5. A recovery ends when less than kStill remains.
///
/// Deformation thread; allocates nothing.
class ViscousRecovery {
 public:
  /// `relaxation_time` (s): 0 for elastic tissue, which keeps the relaxation's own result. `n`:
  /// rows of U.
  ViscousRecovery(double relaxation_time, int n);

  /// Does Relaxation::Relax() of `relaxation`, `dt` (s) after the last call; at least 0.1 ms
  /// counts.
  RelaxationResult Relax(double dt, Relaxation* relaxation, ContactConstraints* contacts, Points* U,
                         RelaxationInput input = {});

  /// True if no recovery remains.
  bool AtRest() const { return U_.isZero(0) && V_.isZero(0); }

  /// Multiplies the state of row `row` by `share` (0..1). 0 starts a row with a new meaning at
  /// rest.
  void ScaleRow(int row, double share) {
    U_.row(row) *= share;
    V_.row(row) *= share;
  }

 private:
  double relaxation_time_;
  Points U_;  // n x 3: where the last step ended
  Points V_;  // n x 3: the rest state of the last step's forces
};

}  // namespace hpdm
