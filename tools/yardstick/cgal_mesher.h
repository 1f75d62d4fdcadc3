#pragma once

#include <functional>

#include "engine/mesh/surface_mesh.h"
#include "engine/reference_fem/tetra_mesh.h"

namespace hpdm {

/// Fills a closed surface (m) with tetrahedra by CGAL's Mesh_3: Delaunay refinement to the size
/// field (bound on the circumradius, m, at a point), then sliver removal. The mesh's own surface
/// lies within `distance` (m) of the given one. The same input gives the same mesh.
TetraMesh FillWithTetrahedra(const SurfaceMesh& surface,
                             const std::function<double(const Vector3d&)>& size, double distance);

}  // namespace hpdm
