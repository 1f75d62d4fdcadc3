#pragma once

#include <cmath>
#include <map>
#include <utility>

#include "engine/mesh/surface_mesh.h"

/// Simple bodies that several tests use.
namespace hpdm {

/// A pose with no symmetry.
inline Isometry3d SomePose() {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.3, -0.2, 0.1);
  return X;
}

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

}  // namespace hpdm
