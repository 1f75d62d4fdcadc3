#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "engine/base/types.h"
#include "engine/mesh/collision.h"

namespace hpdm {

/// The triangles around each vertex. Constant once built; read by any thread.
class SurfaceTopology {
 public:
  SurfaceTopology(Eigen::Index vertex_count, const Triangles& triangles);

  /// Returns the triangles around a vertex, ascending.
  std::span<const int> TrianglesAround(int vertex) const {
    return {triangles_.data() + first_[vertex],
            static_cast<std::size_t>(first_[vertex + 1] - first_[vertex])};
  }

  /// Returns a vertex as a surface point; it must have triangles.
  SurfacePoint AtVertex(const Triangles& triangles, int vertex) const {
    const int triangle = TrianglesAround(vertex).front();
    Vector3d corner = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) corner[k] = triangles(triangle, k) == vertex;
    return {triangle, corner};
  }

 private:
  std::vector<int> first_;      // V + 1
  std::vector<int> triangles_;  // 3 F
};

/// Returns the outward unit normal at a vertex: the area-weighted mean of the normals of the
/// triangles around it. Zero if none of them has area. No allocation.
Vector3d VertexNormal(const Points& vertices, const Triangles& triangles,
                      const SurfaceTopology& topology, int vertex);

/// Returns the outward unit normal at a surface point, interpolated from the normals at its
/// triangle's corners. Zero if no triangle there has area. No allocation.
Vector3d InterpolatedNormal(const Points& vertices, const Triangles& triangles,
                            const SurfaceTopology& topology, const SurfacePoint& at);

/// The triangles around one surface point, nearest first.
struct Neighbourhood {
  static constexpr int kMaxTriangles = 1024;
  int count = 0;
  int vertex_count = 0;  ///< Distinct corners.
  std::array<int, kMaxTriangles> triangles;
};

/// Collects neighbourhoods. Keeps the marks of visited triangles, so Collect() allocates nothing.
/// One thread.
class NeighbourhoodSearch {
 public:
  /// `topology` and `triangles` must outlive the search.
  NeighbourhoodSearch(const Triangles& triangles, const SurfaceTopology& topology);

  struct Limits {
    int triangles = Neighbourhood::kMaxTriangles;            ///< At most kMaxTriangles.
    int vertices = std::numeric_limits<int>::max();          ///< Most distinct corners.
    double reach = std::numeric_limits<double>::infinity();  ///< m, to a triangle's nearest part.
  };

  /// Collects the triangles connected to `at` through shared vertices, within `limits`, in order of
  /// the distance of their centres. They must face less than 90 degrees away from the triangle of
  /// `at`. Distances and normals are those of `vertices` (V x 3, m).
  void Collect(const Points& vertices, const SurfacePoint& at, const Limits& limits,
               Neighbourhood* result);

 private:
  const Triangles* triangles_;
  const SurfaceTopology* topology_;
  std::uint32_t stamp_ = 0;
  std::vector<std::uint32_t> triangle_stamp_;
  std::vector<std::uint32_t> vertex_stamp_;
};

}  // namespace hpdm
