#pragma once

#include <memory>

#include "engine/finite_strain_energy.h"
#include "engine/relaxation.h"

namespace hpdm {

/// Budget and tolerance of Newton's method. Counts, not milliseconds, so that a lockstep run is
/// reproducible.
struct NewtonOptions {
  int max_iterations = 3;   ///< A step; the next one goes on where this one ended.
  double tolerance = 1e-6;  ///< Of the residual |dE/dU - B^T f| / |B^T f|.
};

/// Least energy for strain of any size, by Newton's method from where the last step ended (not from
/// stage A's control points, whose dents under the contacts are a worse start), with line search
/// and, where the Hessian is indefinite, its positive part. The contacts hold exactly after every
/// iteration; what a spent budget leaves is the residual of the equilibrium. Without contact the
/// organ is at rest.
std::unique_ptr<Relaxation> MakeNewtonRelaxation(const FiniteStrainEnergy& energy,
                                                 const NewtonOptions& options = {});

}  // namespace hpdm
