#pragma once

#include <memory>

#include "engine/contact/contact_solver.h"
#include "engine/contact/lattice_compliance.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/solver/refinement_basis.h"
#include "engine/solver/step_quality.h"

namespace hpdm {

/// m: where everything moves by less, nothing moves.
inline constexpr double kStill = 1e-9;

/// Stage B of a step: the control displacements of least energy E(U) that satisfy the contacts,
///     dE/dU = B^T f,   grasp: x = target,   press: f = -n f_n, f_n >= 0, g = n.(target - x) >= 0,
///     f_n g = 0
/// with contact points x = p_rest + B U + C_loc f (engine/README.md, section 4). Below:
/// constant K, E = 1/2 U^T K U; elastic_relaxation.h: strain of any size.
class Relaxation {
 public:
  virtual ~Relaxation() = default;
  /// `U` (n x 3, m): in, where to start (the moved control points of stage A; only iterative
  /// solvers use it); out, the solution. Fills the rows' forces. Deformation thread.
  virtual RelaxationResult Relax(ContactConstraints* contacts, Points* U) = 0;

  /// Whether a Relax without contacts that gave U = 0 would give it again: it keeps no motion of
  /// its own. What is left of one below kStill a step, such a Relax has taken for none.
  virtual bool AtRest() const { return true; }

  /// Takes other local functions in use, for compliance(); Relax does the same.
  virtual void SetActiveFunctions(const ActiveRefinement& /*active*/) {}

  /// The next Relax, which no clock limits then, stops after `iterations` (> 0): where a recorded
  /// one was out of time. Only relaxations with a clock have anything to do here.
  virtual void StopNextAfter(int /*iterations*/) {}

  /// From the next Relax on. Only finite strain has anything to do here.
  virtual void SetQuality(const StepQuality& /*quality*/) {}

  /// The next Relax starts at `U` (n x 3, m) instead of where the last one ended. Only relaxations
  /// that go on from there have anything to do here.
  virtual void RestartFrom(const Points& /*U*/) {}

  /// Takes a damper into the energy of the next Relax, which starts at `from` (n x 3, m) and solves
  ///     dE/dU + damping K (U - from) = B^T f,   K the stiffness at rest.
  /// False: the energy is quadratic and needs none (viscous_recovery.h).
  virtual bool DampNext(double /*damping*/, const Points& /*from*/) { return false; }

  /// What the lattice answers to a small change of the loads, for the contact patch; lives as long
  /// as this. nullptr: there is no such compliance, and the hand feels reaction "paper".
  virtual const LatticeCompliance* compliance() const { return nullptr; }
};

/// Iteration budget and tolerance of Gauss-Seidel. Counts, not milliseconds, so that a lockstep run
/// is reproducible.
struct GaussSeidelOptions {
  int max_sweeps = 2000;
  double tolerance = 1e-6;  ///< Of the residual, and of the contacts relative to the largest one.
};

/// `K`: n x n or 3n x 3n, symmetric positive definite (energy plus supports). Throws InputError
/// when it is not.
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K);
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const FullStiffness& K);
/// Of an organ that does not deform: no unknowns, and each contact's own local compliance, a
/// virtual wall, is all that answers.
std::unique_ptr<Relaxation> MakeRigidRelaxation();
/// With local functions in at most `slots` slots; `functions` must outlive it.
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const RefinementBasis& functions, int slots);

/// The paper's solver, extended by the contacts: one block of three unknowns a control point, the
/// contacts by an augmented Lagrangian whose multipliers rise once a sweep. Its compliance() comes
/// from a Cholesky factorisation of the same K at set-up.
std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const ScalarStiffness& K,
                                                      const GaussSeidelOptions& options = {});
std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const FullStiffness& K,
                                                      const GaussSeidelOptions& options = {});

}  // namespace hpdm
