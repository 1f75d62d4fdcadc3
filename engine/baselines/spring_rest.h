#pragma once

#include <functional>

#include "engine/baselines/mass_spring.h"

namespace hpdm {

/// Returns the forces of the loads (3m, N) from the compliance between them (3m x 3m, m/N) and
/// their patches' displacements without load (3m, m).
using LoadForces =
    std::function<Eigen::VectorXd(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free)>;

struct SpringRest {
  Points displacements;    ///< V x 3, m.
  Eigen::VectorXd forces;  ///< 3m, N.
};

/// Finds the minimum of the springs' energy under loads, by Newton's method with line search. The
/// negative transverse stiffness of compressed springs is left out of the matrix.
///
/// `rows`: 3V x 3m, column 3 i + d a unit force along d on load i. Ends at a residual of 1e-8 or
/// after 100 iterations; the caller checks the residual. Set-up only: allocates and factorises a
/// sparse 3V x 3V matrix in each iteration. Throws InputError (`name`: the organ's) if nothing
/// holds the masses.
SpringRest RestUnderLoads(const MassSpring& model, const Eigen::MatrixXd& rows,
                          const LoadForces& load_forces, const std::string& name);

}  // namespace hpdm
