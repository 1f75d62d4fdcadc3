#include "tools/shared/flat_subdivision.h"

#include <algorithm>
#include <cstdint>
#include <unordered_map>

namespace hpdm {

SurfaceMesh FlatSubdivided(const SurfaceMesh& mesh) {
  const Eigen::Index coarse_vertices = mesh.vertices.rows();
  const Eigen::Index coarse_triangles = mesh.triangles.rows();
  std::unordered_map<std::int64_t, int> middles;  // key of the edge from a to b > a: a V + b
  middles.reserve(static_cast<std::size_t>(2 * coarse_triangles));
  SurfaceMesh fine;
  fine.vertices.resize(coarse_vertices + 3 * coarse_triangles, 3);  // enough even without shared
                                                                    // edges
  fine.vertices.topRows(coarse_vertices) = mesh.vertices;
  fine.triangles.resize(4 * coarse_triangles, 3);
  int next = static_cast<int>(coarse_vertices);
  const auto middle = [&](int a, int b) {
    const auto [low, high] = std::minmax(a, b);
    const auto [it, is_new] = middles.try_emplace(low * std::int64_t{coarse_vertices} + high, next);
    if (is_new) fine.vertices.row(next++) = (mesh.vertices.row(a) + mesh.vertices.row(b)) / 2;
    return it->second;
  };
  for (Eigen::Index t = 0; t < coarse_triangles; ++t) {
    const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
    const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    fine.triangles.middleRows<4>(4 * t) << a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca;
  }
  fine.vertices.conservativeResize(next, 3);
  return fine;
}

SurfaceMesh FlatSubdividedTo(const SurfaceMesh& mesh, Eigen::Index vertices) {
  SurfaceMesh fine = mesh;
  while (fine.vertices.rows() < vertices) fine = FlatSubdivided(fine);
  return fine;
}

}  // namespace hpdm
