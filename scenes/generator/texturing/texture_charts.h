#pragma once

#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A piece of surface that a projection along a coordinate axis flattens without flipping
/// triangles.
struct TextureChart {
  int axis = 0;                ///< 0 to 5: outwards along +x, -x, +y, -y, +z, -z.
  std::vector<int> triangles;  ///< Ascending.
};

/// Returns the outward direction of an axis.
Vector3d ChartDirection(int axis);

/// Projects a point onto the plane of a chart as seen from outside, m. Lengths along both
/// coordinates and the orientation of triangles are preserved.
Eigen::Vector2d ChartPlane(int axis, const Vector3d& p);

/// Cuts a surface into charts. A triangle takes the axis nearest to its normal, or that of most of
/// its neighbours if it is not too oblique. Connected triangles of one axis form a chart; small
/// charts join a neighbour. Uses only + - * / and sqrt: the same bits on every x86-64 machine. The
/// mesh must be sound (mesh_import.h).
std::vector<TextureChart> CutIntoCharts(const SurfaceMesh& mesh);

}  // namespace hpdm
