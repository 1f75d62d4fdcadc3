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
/// 3. With a quadratic energy the relaxation's displacements are that sum (RelaxationInput::free,
///    yield).
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

  /// Begins a step `dt` (s) after the last one; at least 0.1 ms counts. Adds what `relaxation` must
  /// know to `input`, which is valid until End().
  void Begin(double dt, const Relaxation& relaxation, const ContactConstraints& contacts,
             RelaxationInput* input);
  /// Ends it with the displacements of the relaxation.
  void End(const ContactConstraints& contacts, Points* U);

  /// Does Relaxation::Relax() of `relaxation` between both.
  RelaxationResult Relax(double dt, Relaxation* relaxation, ContactConstraints* contacts, Points* U,
                         RelaxationInput input = {});

  /// True if no recovery remains.
  bool AtRest() const { return U_.isZero(0); }

  /// Multiplies the state of row `row` by `share` (0..1). 0 starts a row with a new meaning at
  /// rest.
  void ScaleRow(int row, double share) { U_.row(row) *= share; }

 private:
  double relaxation_time_;
  Points U_;     // n x 3: where the last step ended
  Points free_;  // n x 3: U_free of the present step
};

}  // namespace hpdm
