#pragma once

#include "scenes/generator/meshing/editable_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Makes all edges about `edge_length` (m) long and moves the vertices onto the level set (Botsch
/// and Kobbelt, "A remeshing approach to multiresolution modeling", 2004): splits long edges,
/// collapses short ones, flips towards valence six, and relaxes the vertices along the surface.
void RemeshIsotropically(const ImplicitShape& shape, double level, double edge_length,
                         int iterations, EditableMesh* mesh);

/// Improves the angles and the fit of a coarse mesh without changing its counts:
///
///   1. flips edges if that increases the smallest angle and keeps close to the surface,
///   2. moves each vertex to the intersection of the tangent planes around it, which keeps vertices
///      on sharp borders (Ohtake and Belyaev, "Dual/primal mesh optimization for polygonized
///      implicit surfaces", 2002), and along the surface to the middle of its triangles,
///   3. moves the vertices back onto the level set.
void RelaxOnSurface(const ImplicitShape& shape, double level, int iterations, EditableMesh* mesh);

}  // namespace hpdm
