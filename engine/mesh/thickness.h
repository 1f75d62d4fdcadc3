#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Returns the local thickness of the tissue at each vertex (V, m), at most `at_most`. It is the
/// diameter of the largest inscribed ball within half its radius of the vertex. A thin wall or a
/// wedge is thin.
///
/// 1. Hildebrand and Rueegsegger (1997) require that the ball covers the point. The half radius
///    includes the edges of a right-angled block.
/// 2. The balls touch the surface at the vertices (shrinking balls; Ma, Bae, Choi 2012). Each
///    shrinks until its vertex is the surface point nearest to its centre.
/// 3. A ball stops shrinking if the nearest point lies on the next facet of a curved surface. Such
///    a point is less than 60 degrees away as seen from the centre.
///
/// `normals`: V x 3, unit, outward. The ball of a vertex without a normal has the diameter
/// `at_most`. Set-up only; O(V log F), O(V^2) in the worst case.
Eigen::VectorXd LocalThickness(const SurfaceMesh& mesh, const Points& normals, double at_most);

}  // namespace hpdm
