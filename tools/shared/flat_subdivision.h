#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Every triangle split in four at the middles of its edges: the same surface with about four times
/// the vertices. Those of `mesh` come first.
SurfaceMesh FlatSubdivided(const SurfaceMesh& mesh);

/// Subdivided until it has at least `vertices` vertices.
SurfaceMesh FlatSubdividedTo(const SurfaceMesh& mesh, Eigen::Index vertices);

}  // namespace hpdm
