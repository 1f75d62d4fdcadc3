#include "engine/mesh/surface_topology.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

SurfaceTopology::SurfaceTopology(Eigen::Index vertex_count, const Triangles& triangles)
    : first_(vertex_count + 1, 0), triangles_(triangles.size()) {
  for (int v : triangles.reshaped()) ++first_[v + 1];
  for (Eigen::Index v = 0; v < vertex_count; ++v) first_[v + 1] += first_[v];
  std::vector<int> next(first_.begin(), first_.end() - 1);
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) triangles_[next[triangles(t, k)]++] = static_cast<int>(t);
  }
}

Vector3d VertexNormal(const Points& vertices, const Triangles& triangles,
                      const SurfaceTopology& topology, int vertex) {
  Vector3d normal = Vector3d::Zero();
  for (int t : topology.TrianglesAround(vertex)) normal += TwiceAreaNormal(vertices, triangles, t);
  const double length = normal.norm();
  return length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
}

Vector3d InterpolatedNormal(const Points& vertices, const Triangles& triangles,
                            const SurfaceTopology& topology, const SurfacePoint& at) {
  Vector3d normal = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    normal +=
        at.barycentric[k] * VertexNormal(vertices, triangles, topology, triangles(at.triangle, k));
  }
  const double length = normal.norm();
  return length > 0 ? Vector3d(normal / length) : Vector3d::Zero();
}

NeighbourhoodSearch::NeighbourhoodSearch(const Triangles& triangles,
                                         const SurfaceTopology& topology)
    : triangles_(&triangles),
      topology_(&topology),
      triangle_stamp_(triangles.rows(), 0),
      vertex_stamp_(triangles.size() == 0 ? 0 : triangles.maxCoeff() + 1, 0) {}

void NeighbourhoodSearch::Collect(const Points& vertices, const SurfacePoint& at,
                                  const Limits& limits, Neighbourhood* result) {
  ++stamp_;
  result->count = 0;
  const Vector3d centre = at.Position(vertices, *triangles_);
  const Vector3d facing = TwiceAreaNormal(vertices, *triangles_, at.triangle);
  // Heap of triangles that were seen but not taken, nearest first. A neighbourhood's border stays
  // well below this bound; triangles that do not fit are left out.
  constexpr int kMaxBorder = 1024;
  std::array<std::pair<double, int>, kMaxBorder> border;
  int border_size = 0;
  int vertex_count = 0;
  const auto push = [&](double distance, int t) {
    if (border_size == kMaxBorder) return;
    border[border_size++] = {distance, t};
    std::push_heap(border.begin(), border.begin() + border_size, std::greater<>());
  };
  triangle_stamp_[at.triangle] = stamp_;
  push(0, at.triangle);
  while (border_size > 0 && result->count < limits.triangles) {
    std::pop_heap(border.begin(), border.begin() + border_size, std::greater<>());
    const int t = border[--border_size].second;
    int new_vertices = 0;
    for (int k = 0; k < 3; ++k) new_vertices += vertex_stamp_[(*triangles_)(t, k)] != stamp_;
    if (vertex_count + new_vertices > limits.vertices) continue;
    vertex_count += new_vertices;
    result->triangles[result->count++] = t;
    for (int k = 0; k < 3; ++k) {
      const int v = (*triangles_)(t, k);
      vertex_stamp_[v] = stamp_;
      for (int neighbour : topology_->TrianglesAround(v)) {
        if (triangle_stamp_[neighbour] == stamp_) continue;
        triangle_stamp_[neighbour] = stamp_;
        if (TwiceAreaNormal(vertices, *triangles_, neighbour).dot(facing) <= 0) continue;
        const Vector3d a = vertices.row((*triangles_)(neighbour, 0)),
                       b = vertices.row((*triangles_)(neighbour, 1)),
                       c = vertices.row((*triangles_)(neighbour, 2));
        const Vector3d middle = (a + b + c) / 3;
        const double distance = (middle - centre).norm();
        const double size2 = std::max(
            {(a - middle).squaredNorm(), (b - middle).squaredNorm(), (c - middle).squaredNorm()});
        if (distance - std::sqrt(size2) < limits.reach) push(distance, neighbour);
      }
    }
  }
  result->vertex_count = vertex_count;
}

}  // namespace hpdm
