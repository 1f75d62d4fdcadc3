#pragma once

#include <functional>
#include <memory>

#include "engine/energy/elastic_energy.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// Budget and tolerance of Newton's method in one step. The next step starts where this one ended.
struct NewtonOptions {
  int max_iterations = 3;  ///< At least one iteration is made.
  /// Largest |dE/dU - B^T f| / |B^T f|, with |B^T f| at least the force that moves tissue by 1 nm.
  double tolerance = 1e-6;
  /// s; 0: no limit. An iteration begins only if it would end within the budget when it takes as
  /// long as the step's longest. Without a clock (lockstep) only iterations count, so a run is
  /// reproducible.
  double budget = 0;
  std::function<Nanoseconds()> clock = nullptr;  ///< Session time; must not throw or lock.
  /// Springs of the energy that do not relax with viscoelastic tissue (n x n, N/m, the same along
  /// each axis); nullptr: none. Read at set-up.
  const ScalarStiffness* elastic_supports = nullptr;
};

/// Makes a relaxation for displacements of any size: Newton's method with line search. `energy` is
/// copied.
///
/// 1. It starts where the last step ended, not at stage A's control points, whose dents under the
///    contacts are a worse start. Without contact the organ is at rest.
/// 2. Where the Hessian is indefinite, its positive part replaces it.
/// 3. The contacts hold exactly after every iteration. If the budget ends the iterations, a
///    residual of the equilibrium remains.
/// 4. With StepQuality::finite_strain_blend s below 1 the energy is that of BlendedEnergy. With s =
///    0 it is quadratic, and the step is one solve with K^-1 as in MakeCholeskyRelaxation.
/// 5. The contact patch's compliance is the tangent of the same energy.
/// 6. With `functions`, local functions in `slots` slots add their small-strain displacements to U
///    (schur_complement.h). `functions` must outlive the relaxation.
std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options = {},
                                                 const RefinementBasis* functions = nullptr,
                                                 int slots = 0);

}  // namespace hpdm
