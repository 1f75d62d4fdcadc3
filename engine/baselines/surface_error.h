#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// The measure in which models are compared: the area-weighted relative L2 distance of the surface
/// displacements, sqrt(sum A_v |u_v - r_v|^2 / sum A_v |r_v|^2), with a third of the area of the
/// triangles around each vertex of `rest` as A_v. `u` and `reference` are V x 3, m.
double RelativeSurfaceError(const SurfaceMesh& rest, const Points& u, const Points& reference);

/// Change of the volume that the displaced surface encloses, relative to the one at rest.
double RelativeVolumeChange(const SurfaceMesh& rest, const Points& u);

}  // namespace hpdm
