#pragma once

#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A piece of surface that a projection along a coordinate axis flattens without turning any of its
/// triangles over.
struct TextureChart {
  int axis = 0;                ///< 0 to 5: outwards along +x, -x, +y, -y, +z, -z.
  std::vector<int> triangles;  ///< Ascending.
};

/// Outward direction of an axis.
Vector3d ChartDirection(int axis);

/// A point as a chart along the axis sees it from outside, m: both coordinates keep their length,
/// and triangles that run counter-clockwise still do.
Eigen::Vector2d ChartPlane(int axis, const Vector3d& p);

/// Cuts a surface into charts: triangles take the axis that their normal is nearest to, or most of
/// their neighbours' where that is not too oblique; connected ones of one axis are a chart, and
/// small charts join a neighbour. Only + - * / and sqrt, so the same bits on every x86-64 machine.
/// The mesh must be sound (mesh_import.h).
std::vector<TextureChart> CutIntoCharts(const SurfaceMesh& mesh);

}  // namespace hpdm
