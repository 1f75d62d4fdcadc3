#pragma once

#include "engine/solver/relaxation.h"

namespace hpdm {

/// Tissue that recovers with a relaxation time tau (Kelvin-Voigt: a damper tau K beside every
/// spring), around any relaxation: the contact forces f and the displacements satisfy
///     K (U + tau dU/dt) = B^T f,
/// so a contact feels S (delta + tau d delta/dt) and what is let go decays as exp(-t / tau). Over a
/// step of length dt in which the forces stay the same this has the exact solution
///     U(dt) = e U(0) + (1 - e) V,   K V = B^T f,   e = exp(-dt / tau),
/// and U satisfies the contacts where V, the rest state of the same forces, satisfies them with the
/// targets moved away from e U(0) by 1 / (1 - e) and a local compliance, which answers at once, as
/// much larger.
///
/// With a nonlinear energy there is no such V (it would be the answer to forces that are 1 / (1 -
/// e) times what the tissue ever feels). The damper stays that of the tissue at rest and the same
/// step is taken in the energy itself,
///     dE/dU + e / (1 - e) K (U - U(0)) = B^T f,
/// which is the above where E is quadratic; without contact, U(dt) = e U(0) of either.
///
/// A recovery that has less than kStill left to go is over.
///
/// Deformation thread; allocates nothing.
class ViscousRecovery {
 public:
  /// `relaxation_time` (s): 0 for none, which leaves the relaxation's own result. `n`: rows
  /// of U.
  ViscousRecovery(double relaxation_time, int n);

  /// As Relaxation::Relax() of `relaxation`, `dt` (s) after the last call; less than 0.1 ms counts
  /// as that.
  RelaxationResult Relax(double dt, Relaxation* relaxation, ContactConstraints* contacts,
                         Points* U);

  /// Whether nothing is left to recover from.
  bool AtRest() const { return U_.isZero(0) && V_.isZero(0); }

  /// Unknown `row` keeps `share` (0..1) of where it was: 0 where it means something else from now
  /// on and starts at rest.
  void ScaleRow(int row, double share) {
    U_.row(row) *= share;
    V_.row(row) *= share;
  }

 private:
  double relaxation_time_;
  Points U_;  // n x 3: where the last step ended
  Points V_;  // n x 3
};

}  // namespace hpdm
