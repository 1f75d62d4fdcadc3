#pragma once

#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"

/// Simple bodies for measurements and tests.
namespace hpdm {

/// An ellipsoid with the half-axes `radii` (m) from an icosahedron split `splits` times:
/// 20 x 4^splits triangles, outwards.
inline SurfaceMesh Ellipsoid(const Vector3d& radii, int splits,
                             const Isometry3d& X_WO = Isometry3d::Identity()) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  SurfaceMesh mesh;
  mesh.vertices.resize(12, 3);
  mesh.vertices << -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g, 0, 0, -1, g, 0, 1, g, 0, -1, -g, 0, 1, -g,
      g, 0, -1, g, 0, 1, -g, 0, -1, -g, 0, 1;
  mesh.triangles.resize(20, 3);
  mesh.triangles << 0, 11, 5, 0, 5, 1, 0, 1, 7, 0, 7, 10, 0, 10, 11, 1, 5, 9, 5, 11, 4, 11, 10, 2,
      10, 7, 6, 7, 1, 8, 3, 9, 4, 3, 4, 2, 3, 2, 6, 3, 6, 8, 3, 8, 9, 4, 9, 5, 2, 4, 11, 6, 2, 10,
      8, 6, 7, 9, 8, 1;
  for (int split = 0; split < splits; ++split) {
    const Eigen::Index old_vertices = mesh.vertices.rows();
    const Eigen::Index old_triangles = mesh.triangles.rows();
    Points vertices(old_vertices + old_triangles * 3 / 2, 3);
    vertices.topRows(old_vertices) = mesh.vertices;
    Triangles triangles(4 * old_triangles, 3);
    std::map<std::pair<int, int>, int> middles;
    int next = static_cast<int>(old_vertices);
    const auto middle = [&](int a, int b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), next);
      if (added) vertices.row(next++) = (vertices.row(a) + vertices.row(b)) / 2;
      return it->second;
    };
    for (Eigen::Index t = 0; t < old_triangles; ++t) {
      const int a = mesh.triangles(t, 0), b = mesh.triangles(t, 1), c = mesh.triangles(t, 2);
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      triangles.row(4 * t) << a, ab, ca;
      triangles.row(4 * t + 1) << b, bc, ab;
      triangles.row(4 * t + 2) << c, ca, bc;
      triangles.row(4 * t + 3) << ab, bc, ca;
    }
    mesh.vertices = vertices;
    mesh.triangles = triangles;
  }
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    const Vector3d unit = mesh.vertices.row(v).normalized();
    mesh.vertices.row(v) = X_WO * Vector3d(unit.cwiseProduct(radii));
  }
  return mesh;
}

/// The surface of the box [low, high] with `squares` squares along each axis, each of two
/// triangles, outwards.
inline SurfaceMesh GridBox(const Vector3d& low, const Vector3d& high,
                           const std::array<int, 3>& squares) {
  std::map<std::array<int, 3>, int> numbers;
  std::vector<std::array<int, 3>> triangles;
  const auto vertex = [&](const std::array<int, 3>& at) {
    return numbers.try_emplace(at, static_cast<int>(numbers.size())).first->second;
  };
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3, f = (d + 2) % 3;
    for (const int side : {0, squares[d]}) {
      for (int i = 0; i < squares[e]; ++i) {
        for (int j = 0; j < squares[f]; ++j) {
          std::array<int, 4> v;
          for (int k = 0; k < 4; ++k) {
            std::array<int, 3> at;
            at[d] = side;
            at[e] = i + (k == 1 || k == 2);
            at[f] = j + (k >= 2);
            v[k] = vertex(at);
          }
          if (side == 0) std::swap(v[1], v[3]);
          triangles.push_back({v[0], v[1], v[2]});
          triangles.push_back({v[0], v[2], v[3]});
        }
      }
    }
  }
  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(numbers.size()), 3);
  for (const auto& [at, v] : numbers) {
    for (int d = 0; d < 3; ++d) {
      mesh.vertices(v, d) = low[d] + (high[d] - low[d]) * at[d] / squares[d];
    }
  }
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const auto& [a, b, c] = triangles[t];
    mesh.triangles.row(static_cast<Eigen::Index>(t)) << a, b, c;
  }
  return mesh;
}

}  // namespace hpdm
