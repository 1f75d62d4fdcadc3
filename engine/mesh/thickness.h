#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// The local thickness of the tissue (V, m): the diameter of the largest ball inside the surface
/// that is within half its radius of the vertex (Hildebrand, Rueegsegger 1997, who ask that it
/// covers the point; this takes in the edge of a right-angled block), or `at_most`. A thin wall or
/// a wedge is thin. The balls are those that touch at the vertices, by shrinking (Ma, Bae, Choi
/// 2012): each shrinks until the surface nearest to its centre is its vertex, and stops where that
/// is only the next facet of a surface that is curved there (seen from the centre within 60
/// degrees). `normals`: V x 3, unit, outward; a vertex without one has a ball of `at_most`. Set-up
/// only; O(V log F), and O(V^2) in the worst case.
Eigen::VectorXd LocalThickness(const SurfaceMesh& mesh, const Points& normals, double at_most);

}  // namespace hpdm
