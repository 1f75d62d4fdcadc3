#pragma once

#include "scenes/generator/meshing/editable_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Makes all edges about `edge_length` (m) long and moves the vertices onto the level set: splits
/// long edges, collapses short ones, flips towards valence six, evens the vertices out along the
/// surface (Botsch and Kobbelt, "A remeshing approach to multiresolution modeling", 2004).
void RemeshIsotropically(const ImplicitShape& shape, double level, double edge_length,
                         int iterations, EditableMesh* mesh);

/// Improves the angles and the fit of a coarse mesh without changing its counts: flips edges where
/// that widens the smallest angle and does not cut off the surface, and moves each vertex to where
/// the tangent planes around it meet (so that vertices stay on a sharp border: Ohtake and Belyaev,
/// "Dual/primal mesh optimization for polygonized implicit surfaces", 2002) and, along the surface,
/// to the middle of its triangles; then back onto the level set.
void RelaxOnSurface(const ImplicitShape& shape, double level, int iterations, EditableMesh* mesh);

}  // namespace hpdm
