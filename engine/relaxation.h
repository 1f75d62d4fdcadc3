#pragma once

#include <memory>

#include "engine/contact_set.h"
#include "engine/metric_energy.h"
#include "engine/organ_options.h"

namespace hpdm {

/// How a relaxation ended.
struct RelaxationResult {
  int iterations = 0;        ///< Sweeps (Gauss-Seidel) or changes of the active set (Cholesky).
  double residual = 0;       ///< |K U - B^T f| / |B^T f|, or 0 without force.
  bool converged = true;     ///< False when the iteration budget was spent first.
  bool regularised = false;  ///< Contacts (nearly) coincide and share their force.
};

/// Stage B of a step: the control displacements of least energy 1/2 U^T K U that obey the contacts,
///     K U = B^T f,   grasp: x = target,   press: f = -n f_n, f_n >= 0, g = n.(target - x) >= 0,
///     f_n g = 0
/// with contact points x = p_rest + B U (design: one deformation step).
class Relaxation {
 public:
  virtual ~Relaxation() = default;
  /// `U` (n x 3, m): in, where to start (the moved control points of stage A; only iterative
  /// solvers use it); out, the solution. Fills the rows' forces. Deformation thread.
  virtual RelaxationResult Relax(ContactSet* contacts, Points* U) = 0;
};

/// Iteration budget and tolerance of Gauss-Seidel. Counts, not milliseconds, so that a lockstep run
/// is reproducible.
struct GaussSeidelOptions {
  int max_sweeps = 2000;
  double tolerance = 1e-6;  ///< Of the residual, and of the contacts relative to the largest one.
};

/// `K`: n x n, symmetric positive definite (energy plus supports). Throws InputError when it is
/// not.
std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K);

/// The paper's solver, extended by the contacts: one block of three unknowns a control point, the
/// contacts by an augmented Lagrangian whose multipliers rise once a sweep.
std::unique_ptr<Relaxation> MakeGaussSeidelRelaxation(const ScalarStiffness& K,
                                                      const GaussSeidelOptions& options = {});

}  // namespace hpdm
