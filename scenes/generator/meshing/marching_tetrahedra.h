#pragma once

#include "engine/mesh/surface_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Returns the level set field = `level` (m) of a shape as a closed, manifold, outward surface.
///
/// 1. A grid of cubes of side `spacing` (m) covers the shape's bounds.
/// 2. Each cube is divided into six tetrahedra around one diagonal (Kuhn's triangulation). They
///    match across the cubes' faces.
/// 3. The surface crosses each tetrahedron's edges where the linear interpolation has the level.
///
/// Details thinner than the spacing may be lost. Throws InputError if the level set is empty or
/// leaves the bounds.
SurfaceMesh MarchTetrahedra(const ImplicitShape& shape, double level, double spacing);

}  // namespace hpdm
