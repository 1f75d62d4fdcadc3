#pragma once

#include "scenes/generator/meshing/editable_mesh.h"

namespace hpdm {

/// Collapses edges until exactly `triangle_count` (even) triangles remain, in the order of the
/// quadric error (Garland and Heckbert 1997). A small cost on length keeps triangles even in flat
/// regions. Refuses collapses that break the manifold, turn a triangle by more than 60 degrees or
/// create a sliver. Throws InputError if the count is odd, above the mesh's or impossible.
void Decimate(int triangle_count, EditableMesh* mesh);

}  // namespace hpdm
