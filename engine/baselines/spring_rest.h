#pragma once

#include <functional>

#include "engine/baselines/mass_spring.h"

namespace hpdm {

/// The forces of the loads (3m, N) from the compliance between them (3m x 3m, m/N) and where their
/// patches are without load (3m, m).
using LoadForces =
    std::function<Eigen::VectorXd(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free)>;

struct SpringRest {
  Points displacements;    ///< V x 3, m.
  Eigen::VectorXd forces;  ///< 3m, N.
};

/// Where the masses come to rest under loads: the least of the springs' energy, by Newton's method
/// with line search. A compressed spring has a negative stiffness across itself, which is left out
/// of the matrix. `rows`: 3V x 3m, column 3 i + d a unit force along d on load i. Ends at a
/// residual of 1e-8 or after 100 iterations; the residual of what it returns is the caller's to
/// judge. Set-up only: allocates, and factorises a sparse 3V x 3V matrix an iteration. Throws
/// InputError
/// (`name`: the organ's) when nothing holds the masses.
SpringRest RestUnderLoads(const MassSpring& model, const Eigen::MatrixXd& rows,
                          const LoadForces& load_forces, const std::string& name);

}  // namespace hpdm
