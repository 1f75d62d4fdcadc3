#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Flips triangles until the surface bounds its solid, and returns how many were flipped.
///
/// 1. Triangles joined by edges of exactly two triangles form a patch. Within a two-sided patch all
///    triangles get the same orientation.
/// 2. A closed patch faces outwards. If an odd number of other closed patches surround it, it is
///    the wall of a cavity and faces inwards. Only the 64 largest patches count as surrounding
///    ones.
/// 3. An open patch faces the way it bulges, or if it bulges little, the way most of its area
///    faced.
///
/// The corners of each triangle must be distinct; they keep their texture coordinates. O(F log F),
/// apart from patches inside others.
int OrientTriangles(SurfaceMesh* mesh);

}  // namespace hpdm
