#pragma once

#include <functional>
#include <memory>

#include "engine/energy/elastic_energy.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// Iterations that load shedding leaves. The first one is taken whole; fewer cannot correct it.
inline constexpr int kLeastNewtonIterations = 3;

/// Budget and tolerance of the iterations in one step. The next step starts where this one ended.
struct NewtonOptions {
  int max_iterations = 24;  ///< At least one iteration is made.
  /// Largest residual: the length of the next step in the norm of the energy over that of the
  /// displacements under the contacts' forces alone, at least that of a motion by 1 nm. The forces
  /// differ from those of the equilibrium by about its square.
  double tolerance = 1e-3;
  /// s; 0: no limit. An iteration begins only if it would end within the budget when it takes as
  /// long as the step's longest. Without a clock (lockstep) only iterations count, so a run is
  /// reproducible.
  double budget = 0;
  std::function<Nanoseconds()> clock = nullptr;  ///< Session time; must not throw or lock.
  /// Springs of the energy that do not relax with viscoelastic tissue (n x n, N/m, the same along
  /// each axis); nullptr: none. Read at set-up.
  const ScalarStiffness* elastic_supports = nullptr;
};

/// Makes a relaxation for displacements of any size: a quasi-Newton method with line search. `energy`
/// is copied. `K` (3n x 3n, N/m): stiffness of small strain; without it that of `energy` at rest.
///
/// 1. It starts where the last step ended, not at stage A's control points, whose dents under the
///    contacts are a worse start. Without contact the organ is at rest.
/// 2. The inverse Hessian is approximated by R K^-1 R^T, with R the rotation of the tissue as a
///    whole, and by the gradients of the last iterations (secant_memory.h), also those of earlier
///    steps. So an iteration costs one gradient and one product with K^-1, and nothing is
///    factorised.
/// 3. The contacts hold exactly after every iteration. If the budget ends the iterations, a
///    residual of the equilibrium remains.
/// 4. With StepQuality::finite_strain_blend s below 1 the energy is that of BlendedEnergy. With s =
///    0 it is quadratic, and the step is one solve with K^-1 as in MakeCholeskyRelaxation.
/// 5. The contact patch's compliance is that approximation after the last iteration.
/// 6. With `functions`, local functions in `slots` slots are unknowns like the lattice's.
///    `functions` must outlive the relaxation, and `K` must be that of which they were built.
std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options = {},
                                                 const FullStiffness* K = nullptr,
                                                 const RefinementBasis* functions = nullptr,
                                                 int slots = 0);

}  // namespace hpdm
