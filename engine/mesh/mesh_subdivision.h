#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Subdivide() makes no more triangles than this.
inline constexpr int kMaxSubdividedTriangles = 4'000'000;

/// The mesh with every triangle split in four `times` times, on the smooth surface that Loop's
/// rules lead to (Loop, "Smooth subdivision surfaces based on triangles", 1987; a border, or an
/// edge of more than two triangles, becomes a cubic B-spline curve). A closed surface of smooth
/// shape loses a little volume. Texture coordinates are split evenly. The first V vertices stay the
/// first. O(F log F) for the finest. Throws InputError (`name`: the file's) where it would exceed
/// kMaxSubdividedTriangles.
SurfaceMesh Subdivided(const SurfaceMesh& mesh, int times, const char* name);

}  // namespace hpdm
