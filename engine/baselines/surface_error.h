#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Returns the area-weighted relative L2 distance between two surface displacements, by which
/// models are compared:
///     sqrt(sum A_v |u_v - r_v|^2 / sum A_v |r_v|^2),
/// with A_v a third of the area of the triangles around vertex v of `rest`. `u` and `reference` are
/// V x 3, m.
double RelativeSurfaceError(const SurfaceMesh& rest, const Points& u, const Points& reference);

/// Returns the relative change of the enclosed volume by the displacement `u`.
double RelativeVolumeChange(const SurfaceMesh& rest, const Points& u);

}  // namespace hpdm
