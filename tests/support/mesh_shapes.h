#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"

/// Closed shapes with known facts, and where the shared test data lies, for the tests of meshes.
namespace hpdm {

/// Absent outside the development tree: tests that need it skip.
inline const std::string kDataFolder = std::string(HPDM_SOURCE_DIR) + "/../shared/data/";

inline SurfaceMesh MakeMesh(const std::vector<Vector3d>& vertices,
                            const std::vector<std::array<int, 3>>& triangles) {
  SurfaceMesh mesh;
  mesh.vertices.resize(static_cast<Eigen::Index>(vertices.size()), 3);
  mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    mesh.vertices.row(static_cast<Eigen::Index>(v)) = vertices[v].transpose();
  }
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    mesh.triangles.row(static_cast<Eigen::Index>(t)) << triangles[t][0], triangles[t][1],
        triangles[t][2];
  }
  return mesh;
}

/// The box [low, high] as 12 triangles that face outwards.
inline SurfaceMesh MakeBox(const Vector3d& low, const Vector3d& high) {
  std::vector<Vector3d> vertices;
  for (int i = 0; i < 8; ++i) {
    vertices.emplace_back(i & 1 ? high.x() : low.x(), i & 2 ? high.y() : low.y(),
                          i & 4 ? high.z() : low.z());
  }
  return MakeMesh(vertices, {{0, 2, 3},
                             {0, 3, 1},
                             {4, 5, 7},
                             {4, 7, 6},
                             {0, 1, 5},
                             {0, 5, 4},
                             {2, 6, 7},
                             {2, 7, 3},
                             {0, 4, 6},
                             {0, 6, 2},
                             {1, 3, 7},
                             {1, 7, 5}});
}

/// An icosahedron whose triangles are split in four `level` times, on the sphere: 20 * 4^level
/// triangles. Its volume falls short of the sphere's by about 1.4 / 4^level.
inline SurfaceMesh MakeSphere(int level, double radius = 1) {
  const double phi = std::numbers::phi;
  std::vector<Vector3d> v = {{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                             {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                             {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
  std::vector<std::array<int, 3>> triangles = {
      {0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int l = 0; l < level; ++l) {
    std::map<std::pair<int, int>, int> middles;
    const auto middle = [&](int i, int j) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(i, j), static_cast<int>(v.size()));
      if (is_new) v.push_back((v[static_cast<std::size_t>(i)] + v[static_cast<std::size_t>(j)]));
      return at->second;
    };
    std::vector<std::array<int, 3>> finer;
    for (Vector3d& p : v) p.normalize();
    for (const auto& [a, b, c] : triangles) {
      const int ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
      for (const int m : {ab, bc, ca}) v[static_cast<std::size_t>(m)].normalize();
    }
    triangles = finer;
  }
  for (Vector3d& p : v) p *= radius / p.norm();
  return MakeMesh(v, triangles);
}

/// Turns every triangle round.
inline SurfaceMesh Reversed(SurfaceMesh mesh) {
  mesh.triangles.col(1).swap(mesh.triangles.col(2));
  return mesh;
}

/// Both surfaces as one mesh.
inline SurfaceMesh Joined(const SurfaceMesh& a, const SurfaceMesh& b) {
  SurfaceMesh mesh;
  mesh.vertices.resize(a.vertices.rows() + b.vertices.rows(), 3);
  mesh.vertices << a.vertices, b.vertices;
  mesh.triangles.resize(a.triangles.rows() + b.triangles.rows(), 3);
  mesh.triangles << a.triangles,
      (b.triangles.array() + static_cast<int>(a.vertices.rows())).matrix();
  return mesh;
}

/// Without the triangles whose numbers lie in [first, first + count).
inline SurfaceMesh Without(SurfaceMesh mesh, Eigen::Index first, Eigen::Index count) {
  Triangles kept(mesh.triangles.rows() - count, 3);
  kept << mesh.triangles.topRows(first), mesh.triangles.bottomRows(kept.rows() - first);
  mesh.triangles = kept;
  return mesh;
}

/// A torus about z with n x n quadrilaterals.
inline SurfaceMesh MakeTorus(int n, double major, double minor) {
  std::vector<Vector3d> vertices;
  std::vector<std::array<int, 3>> triangles;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      const double u = 2 * std::numbers::pi * i / n, w = 2 * std::numbers::pi * j / n;
      const double r = major + minor * std::cos(w);
      vertices.emplace_back(r * std::cos(u), r * std::sin(u), minor * std::sin(w));
      const int a = i * n + j, b = (i + 1) % n * n + j, c = (i + 1) % n * n + (j + 1) % n,
                d = i * n + (j + 1) % n;
      triangles.insert(triangles.end(), {{a, b, c}, {a, c, d}});
    }
  }
  return MakeMesh(vertices, triangles);
}

}  // namespace hpdm
