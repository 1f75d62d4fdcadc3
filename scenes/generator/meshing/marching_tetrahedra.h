#pragma once

#include "engine/mesh/surface_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Returns the level set field = `level` (m) of a shape as a closed, manifold, outward surface.
/// Method: a grid of cubes of side `spacing` (m) over the shape's bounds, six tetrahedra a cube
/// along one diagonal (Kuhn's triangulation, which matches across faces), and linear interpolation
/// on the edges. Details thinner than the spacing may be lost. Throws InputError if the level set
/// is empty or leaves the bounds.
SurfaceMesh MarchTetrahedra(const ImplicitShape& shape, double level, double spacing);

}  // namespace hpdm
