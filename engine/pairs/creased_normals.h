#pragma once

#include <cstdint>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"

namespace hpdm {

/// Unit normals of a deforming surface that keep its creases: on a box they are those of its
/// faces up to the edges, on a smooth surface those of InterpolatedNormal (surface_topology.h).
///
/// The normal at a triangle's corner is the area-weighted mean over the triangles around the
/// vertex whose rest normals are within 60 degrees of its own. Sized once. A step computes only the
/// corners that it asks for and allocates nothing. One thread.
class CreasedNormals {
 public:
  /// `rest`, `topology` must outlive it.
  CreasedNormals(const SurfaceMesh& rest, const SurfaceTopology& topology);

  /// Takes the step's shape, `vertices` (V x 3, m), by reference.
  void Begin(const Points& vertices);
  /// Returns the outward unit normal, interpolated from the triangle's corners; zero without area.
  Vector3d At(const SurfacePoint& at);

 private:
  const Vector3d& AtCorner(int triangle, int k);

  const Triangles* triangles_;
  const Points* vertices_;
  std::vector<int> first_;   // 3F + 1
  std::vector<int> around_;  // triangles of each corner's mean
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> stamps_;  // 3F
  std::vector<Vector3d> normals_;      // 3F
};

/// Returns true if a point is inside a closed surface, by its closest point there: the sign of the
/// angle-weighted normal of the face, edge or corner that holds it (Baerentzen and Aanaes 2005).
/// `offset`: from the closest point to the point, m. No allocation.
bool IsBehind(const Vector3d& offset, const SurfacePoint& closest, const Points& vertices,
              const Triangles& triangles, const SurfaceTopology& topology);

}  // namespace hpdm
