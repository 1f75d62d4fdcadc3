#pragma once

#include "engine/lattice/relocation.h"
#include "tools/chart/static_case_model.h"
#include "tools/shared/timing.h"

/// Times of relocation on a surface of one size, so that steps of different cases compare.
namespace hpdm {

/// Returns the vertices (15,000 x 3, m) of the same surface in 30,000 triangles or more.
Points FineVertices(const SurfaceMesh& rest);

/// Times the motion of `vertices` (V x 3, m) with the control points or nodes of `weights` (V x n).
Timing TimeRelocation(const Points& vertices, const WeightMatrix& weights);

/// Times the relocation of `fine_vertices` with the lattice of `body` and the parts added at its
/// loads. `indentations` is the time of these parts for the `vertices` of the case's own surface.
Timing TimeFineRelocation(const StaticCaseModel& body, const Points& fine_vertices,
                          const Timing& indentations, Eigen::Index vertices);

}  // namespace hpdm
