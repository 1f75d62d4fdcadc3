#pragma once

#include <array>

#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"

/// The curved surface that a tip meets over a mesh's flat triangles.
///
/// A press acts along the interpolated vertex normal. Flat triangles are not perpendicular to it, so
/// a tip that slides over them would do work that no tissue stores: 2 % of a press of 5 mm on edges
/// of 15 mm. The quadratic triangle of Phong tessellation (Boubekeur and Alexa 2008, with their
/// alpha = 1/2) is perpendicular to it to first order in the turn of the normals:
///     q(w) = p + 1/2 sum_i w_i n_i n_i . (v_i - p),   p = sum_i w_i v_i.
/// It passes through the vertices v_i with the normals n_i and is continuous across edges. On a
/// sphere it is exact to second order. Sharp edges stay as they are: a vertex whose normal is more
/// than 26 degrees off a face around it does not bend the surface.
namespace hpdm {

/// Least cosine of the angle between the normal of a vertex that bends the surface and its faces.
inline constexpr double kSmoothCosine = 0.9;

/// Returns q - p, m. `corners`: v_i, m; `normals`: n_i, unit, or zero for a vertex that does not bend
/// the surface; `weights`: barycentric. Any thread; no allocation.
inline Vector3d CurvedOffset(const std::array<Vector3d, 3>& corners,
                             const std::array<Vector3d, 3>& normals, const Vector3d& weights) {
  const Vector3d p = weights[0] * corners[0] + weights[1] * corners[1] + weights[2] * corners[2];
  Vector3d offset = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    offset += weights[i] / 2 * normals[i].dot(corners[i] - p) * normals[i];
  }
  return offset;
}

/// Turns vertex normals (V x 3, unit) so that the curved surface is perpendicular to them: the mean
/// normal of the ends of each edge between smooth vertices is perpendicular to the edge, in least
/// squares. So it is on every sphere and, to second order, on every smooth surface; means of the
/// faces' normals are off by some thousandths where triangles are unequal. These means hold the normals,
/// so that an edge which counts as smooth makes no ripples. Deterministic; set-up only.
void FitNormals(const SurfaceMesh& mesh, const SurfaceTopology& topology, Points* normals);

/// Returns q - p at a point of a mesh, m. `normals`: its vertex normals, V x 3. Any thread; no
/// allocation.
Vector3d CurvedOffset(const SurfaceMesh& mesh, const SurfaceTopology& topology,
                      const Points& normals, const SurfacePoint& at);

}  // namespace hpdm
