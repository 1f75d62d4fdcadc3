#pragma once

#include "scenes/generator/meshing/editable_mesh.h"

namespace hpdm {

/// Collapses edges until exactly `triangle_count` (even) triangles remain, cheapest quadric error
/// first (Garland and Heckbert 1997), with a small cost on length so that flat regions keep even
/// triangles. Refuses collapses that break the manifold, turn a triangle by more than 60 degrees or
/// make a sliver where there was none. Throws InputError when the count is odd, above the mesh's or
/// out of reach.
void Decimate(int triangle_count, EditableMesh* mesh);

}  // namespace hpdm
