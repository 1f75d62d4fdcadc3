#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Most triangles that Subdivided() makes.
inline constexpr int kMaxSubdividedTriangles = 4'000'000;

/// Splits every triangle in four, `times` times, by Loop's rules for a smooth surface (Loop,
/// "Smooth subdivision surfaces based on triangles", 1987).
///
/// 1. A border, or an edge of more than two triangles, becomes a cubic B-spline curve.
/// 2. A closed surface of smooth shape loses a little volume.
/// 3. Texture coordinates are interpolated linearly.
/// 4. The vertices of `mesh` stay the first ones of the result.
///
/// The corners of each triangle must be distinct. O(F log F) in the triangles of the result. Throws
/// InputError (`name`: of the mesh file) if the result would exceed kMaxSubdividedTriangles.
SurfaceMesh Subdivided(const SurfaceMesh& mesh, int times, const char* name);

}  // namespace hpdm
