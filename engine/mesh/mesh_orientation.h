#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Turns triangles until the surface bounds its solid, and returns how many were turned. Triangles
/// that share an edge with exactly one other form a patch; within it all run the same way round
/// (where the patch is two-sided). Then each patch as a whole:
/// - closed: faces outwards, or, when an odd number of other closed patches surround it, inwards:
///   it is the wall of a cavity (of the 64 largest patches any may be the surrounding one);
/// - open: faces where it bulges to, if it does so clearly, else where most of its area faced.
/// Corners of each triangle must be distinct and take their texture coordinates along. O(F log F)
/// but for the patches inside others.
int OrientTriangles(SurfaceMesh* mesh);

}  // namespace hpdm
