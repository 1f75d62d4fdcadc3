#pragma once

#include <functional>
#include <memory>

#include "engine/energy/elastic_energy.h"
#include "engine/solver/relaxation.h"

namespace hpdm {

/// Budget and tolerance of Newton's method in one step. The next step goes on where this one ended.
struct NewtonOptions {
  int max_iterations = 3;   ///< At least one is made.
  double tolerance = 1e-6;  ///< Of the residual |dE/dU - B^T f| / |B^T f| (1 nm's force or more).
  /// s; an iteration that would end later, as the longest one of this step did, is not begun. 0:
  /// no limit. Without a clock (lockstep) iterations alone count, so that a run is reproducible.
  double budget = 0;
  std::function<Nanoseconds()> clock = nullptr;  ///< Session time; must not throw or lock.
};

/// Least energy for displacements of any size, by Newton's method from where the last step ended
/// (not from stage A's control points, whose dents under the contacts are a worse start), with line
/// search and, where the Hessian is indefinite, its positive part. The contacts hold exactly after
/// every iteration; what a spent budget leaves is the residual of the equilibrium. Without contact
/// the organ is at rest. `energy` is copied.
///
/// With StepQuality::finite_strain_blend s below 1 the energy is that of BlendedEnergy; with s = 0
/// it is quadratic and the step one solve with K^-1, as in MakeCholeskyRelaxation. The contact
/// patch's compliance is the tangent of the same energy.
///
/// With `functions`, local functions in `slots` slots add to U what they do in small strain
/// (schur_complement.h). `functions` must outlive the relaxation.
std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options = {},
                                                 const RefinementBasis* functions = nullptr,
                                                 int slots = 0);

}  // namespace hpdm
