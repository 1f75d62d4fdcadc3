#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// How far two closed surfaces are apart, or how deep one is in the other.
struct OrganOverlap {
  /// m. Largest depth of a point of one surface in the other, or 0: they are apart.
  double depth = 0;
  /// m. Least distance if they are apart, or 0.
  double distance = 0;
  Vector3d place_W = Vector3d::Zero();  ///< Where that is, m.
};

/// Measures two posed surfaces (m, world) from each side: at the vertices and at samples about 2 mm
/// apart. A point is inside by the generalised winding number, so an organ that lies wholly within
/// another one is found, and one in the other's cavity overlaps nothing. Set-up only: allocates.
OrganOverlap MeasureOverlap(const SurfaceMesh& a, const SurfaceMesh& b);

}  // namespace hpdm
