#pragma once

#include "engine/surface_mesh.h"

namespace hpdm {

/// Diameter of the largest ball inside the surface that touches it at each vertex, or `at_most` (V,
/// m): the local thickness of the tissue, small at an edge and in a wall. By shrinking balls (Ma,
/// Bae, Choi 2012): a ball that touches at the vertex shrinks until the surface nearest to its
/// centre is the vertex, and stops where that is only the next facet of a surface that is curved
/// there (seen from the centre within 60 degrees). `normals`: V x 3, unit, outward. A vertex
/// without normal gets `at_most`. Set-up only; O(V log F).
Eigen::VectorXd LocalThickness(const SurfaceMesh& mesh, const Points& normals, double at_most);

}  // namespace hpdm
