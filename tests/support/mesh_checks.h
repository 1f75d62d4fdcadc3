#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"

/// Checks of surfaces for tests. They compare every pair of triangles.
namespace hpdm {

/// Directed edges that do not occur exactly once with exactly one opposite: 0 means closed,
/// manifold along its edges and consistently oriented.
inline int EdgeDefects(const SurfaceMesh& mesh) {
  std::map<std::pair<int, int>, int> count;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      ++count[{mesh.triangles(t, k), mesh.triangles(t, (k + 1) % 3)}];
    }
  }
  int defects = 0;
  for (const auto& [edge, times] : count) {
    const auto opposite = count.find({edge.second, edge.first});
    defects += edge.first == edge.second || times != 1 || opposite == count.end();
  }
  return defects;
}

/// Component of each vertex, numbered in the order of first vertices.
inline std::vector<int> Components(const SurfaceMesh& mesh) {
  std::vector<int> parent(mesh.vertices.rows());
  for (std::size_t v = 0; v < parent.size(); ++v) parent[v] = static_cast<int>(v);
  const auto root = [&parent](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int k = 1; k < 3; ++k) {
      const int a = root(mesh.triangles(t, 0)), b = root(mesh.triangles(t, k));
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  std::map<int, int> number;
  std::vector<int> component(parent.size());
  for (std::size_t v = 0; v < parent.size(); ++v) {
    const int r = root(static_cast<int>(v));
    component[v] = number.emplace(r, static_cast<int>(number.size())).first->second;
  }
  return component;
}

/// V - E + F; a closed surface without handles has 2 for each component. Together with EdgeDefects
/// = 0 this also finds vertices where two sheets touch.
inline int EulerCharacteristic(const SurfaceMesh& mesh) {
  return static_cast<int>(mesh.vertices.rows() - mesh.triangles.rows() / 2);
}

/// Corners of triangle t.
inline std::array<Vector3d, 3> Corners(const SurfaceMesh& mesh, Eigen::Index t) {
  return {mesh.vertices.row(mesh.triangles(t, 0)), mesh.vertices.row(mesh.triangles(t, 1)),
          mesh.vertices.row(mesh.triangles(t, 2))};
}

/// Smallest angle of every triangle, degrees, ascending.
inline std::vector<double> SmallestAngles(const SurfaceMesh& mesh) {
  std::vector<double> angles;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const std::array<Vector3d, 3> p = Corners(mesh, t);
    double least = 180;
    for (int k = 0; k < 3; ++k) {
      const Vector3d u = p[(k + 1) % 3] - p[k], v = p[(k + 2) % 3] - p[k];
      least = std::min(least, std::atan2(u.cross(v).norm(), u.dot(v)) * 57.29577951308232);
    }
    angles.push_back(least);
  }
  std::sort(angles.begin(), angles.end());
  return angles;
}

/// True if the segment ab passes through the inside of a triangle.
inline bool SegmentCrosses(const Vector3d& a, const Vector3d& b,
                           const std::array<Vector3d, 3>& triangle) {
  const auto volume = [](const Vector3d& p, const Vector3d& q, const Vector3d& r,
                         const Vector3d& s) { return (q - p).cross(r - p).dot(s - p); };
  const auto& [p, q, r] = triangle;
  const double side_a = volume(p, q, r, a), side_b = volume(p, q, r, b);
  if (side_a * side_b >= 0) return false;
  const double u = volume(a, b, p, q), v = volume(a, b, q, r), w = volume(a, b, r, p);
  return (u > 0 && v > 0 && w > 0) || (u < 0 && v < 0 && w < 0);
}

/// Pairs of triangles that cut through each other (an edge of one passes through the other), and
/// pairs that share an edge and lie on top of each other (less than two degrees apart).
inline int SelfIntersections(const SurfaceMesh& mesh) {
  const Eigen::Index count = mesh.triangles.rows();
  std::vector<std::array<Vector3d, 3>> triangles(count);
  std::vector<Vector3d> low(count), high(count);
  for (Eigen::Index t = 0; t < count; ++t) {
    triangles[t] = Corners(mesh, t);
    low[t] = triangles[t][0].cwiseMin(triangles[t][1]).cwiseMin(triangles[t][2]);
    high[t] = triangles[t][0].cwiseMax(triangles[t][1]).cwiseMax(triangles[t][2]);
  }
  const auto normal = [&triangles](Eigen::Index t) {
    return (triangles[t][1] - triangles[t][0])
        .cross(triangles[t][2] - triangles[t][0])
        .normalized();
  };
  int pairs = 0;
  for (Eigen::Index s = 0; s < count; ++s) {
    for (Eigen::Index t = s + 1; t < count; ++t) {
      if ((low[s].array() > high[t].array()).any() || (low[t].array() > high[s].array()).any()) {
        continue;
      }
      int shared = 0;
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) shared += mesh.triangles(s, k) == mesh.triangles(t, l);
      }
      if (shared >= 2) {
        pairs += normal(s).dot(normal(t)) < -0.9994;
        continue;
      }
      // Triangles that share one vertex may still cross along the edges opposite to it; edges that
      // start at that vertex have it on the other's plane and so never count.
      bool cross = false;
      for (int k = 0; k < 3 && !cross; ++k) {
        cross = SegmentCrosses(triangles[s][k], triangles[s][(k + 1) % 3], triangles[t]) ||
                SegmentCrosses(triangles[t][k], triangles[t][(k + 1) % 3], triangles[s]);
      }
      pairs += cross;
    }
  }
  return pairs;
}

/// Distance from p to a triangle.
inline double DistanceToTriangle(const Vector3d& p, const std::array<Vector3d, 3>& triangle) {
  const Vector3d normal = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]).normalized();
  bool above = true;
  double nearest = 1e300;
  for (int k = 0; k < 3; ++k) {
    const Vector3d& a = triangle[k];
    const Vector3d edge = triangle[(k + 1) % 3] - a;
    above = above && normal.cross(edge).dot(p - a) >= 0;
    const double s = std::clamp(edge.dot(p - a) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - a - s * edge).norm());
  }
  return above ? std::abs(normal.dot(p - triangle[0])) : nearest;
}

/// Distance from p to a surface.
inline double DistanceToMesh(const Vector3d& p, const SurfaceMesh& mesh) {
  double nearest = 1e300;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    nearest = std::min(nearest, DistanceToTriangle(p, Corners(mesh, t)));
  }
  return nearest;
}

/// The part of a mesh with the given component number (Components), with all its vertices kept.
inline SurfaceMesh Component(const SurfaceMesh& mesh, int number) {
  const std::vector<int> component = Components(mesh);
  std::vector<Eigen::Index> rows;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    if (component[mesh.triangles(t, 0)] == number) rows.push_back(t);
  }
  SurfaceMesh part;
  part.vertices = mesh.vertices;
  part.triangles.resize(rows.size(), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    part.triangles.row(i) = mesh.triangles.row(rows[i]);
  }
  return part;
}

}  // namespace hpdm
