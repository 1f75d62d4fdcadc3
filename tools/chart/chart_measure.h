#pragma once

#include <string>
#include <vector>

#include "tools/chart/chart_point.h"
#include "tools/chart/static_case_model.h"

namespace hpdm {

/// True if the stiffness is that of the tissue. The moduli of the other models are numbers to tune.
/// They are pressed to the depth of the reference's patch, as if tuned to it.
bool HasModulus(const OrganOptions& options);

/// Returns a point that names the model of `options` and has no measurements yet.
ChartPoint Labelled(const std::string& load_case, bool hollow, const OrganOptions& options);

/// Brings a body at rest to equilibrium under the loads; false if it does not converge. The body is
/// made of these three. `reference` (V x 3, m) is the solution, which a model without a modulus
/// follows.
///
/// Gauss-Seidel is timed for one step. The many steps that find the loads' displacements use the
/// direct solver, whose answer is the same.
bool TakeToRest(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                const Points& reference, const OrganOptions& options, StaticCaseModel* body);

}  // namespace hpdm
