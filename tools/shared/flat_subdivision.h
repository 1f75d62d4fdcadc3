#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Splits every triangle in four at the midpoints of its edges. The surface stays the same and has
/// about four times the vertices; the vertices of `mesh` come first.
SurfaceMesh FlatSubdivided(const SurfaceMesh& mesh);

/// Subdivides until the mesh has at least `vertices` vertices.
SurfaceMesh FlatSubdividedTo(const SurfaceMesh& mesh, Eigen::Index vertices);

}  // namespace hpdm
