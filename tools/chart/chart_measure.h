#pragma once

#include <string>
#include <vector>

#include "tools/chart/chart_point.h"
#include "tools/chart/static_case_model.h"

namespace hpdm {

/// Whether the stiffness is that of the tissue. The other models' moduli are numbers to be tuned:
/// they are pressed as deep as the reference's patch goes, as if tuned until that agreed.
bool HasModulus(const OrganOptions& options);

/// A point that names the model of `options` and has no figures.
ChartPoint Labelled(const std::string& load_case, bool hollow, const OrganOptions& options);

/// Takes a body, made of these three and at rest, to rest under the loads, of which `reference` (V
/// x 3, m) is the answer: a model without a modulus follows that. Gauss-Seidel is to be timed for a
/// step, not for the many from which the loads' displacements are found: those are the direct
/// solver's, whose answer is the same. False when the body did not come to rest.
bool TakeToRest(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                const Points& reference, const OrganOptions& options, StaticCaseModel* body);

}  // namespace hpdm
