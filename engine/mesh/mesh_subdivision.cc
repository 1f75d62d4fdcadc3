#include "engine/mesh/mesh_subdivision.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {
namespace {

// A triangle's side: corner `corner` of `triangle` lies opposite to it.
struct Side {
  std::pair<int, int> ends;  // ascending
  int triangle, corner;
  bool operator<(const Side& other) const {
    return std::tie(ends, triangle, corner) < std::tie(other.ends, other.triangle, other.corner);
  }
};

std::vector<Side> SidesOf(const Triangles& triangles) {
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(triangles.size()));
  for (int t = 0; t < triangles.rows(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const int a = triangles(t, (k + 1) % 3), b = triangles(t, (k + 2) % 3);
      sides.push_back({std::minmax(a, b), t, k});
    }
  }
  std::sort(sides.begin(), sides.end());
  return sides;
}

// What a vertex has around it.
struct Ring {
  Vector3d neighbours = Vector3d::Zero();  // their sum, m
  int count = 0;
  Vector3d along = Vector3d::Zero();  // of those along border edges
  int borders = 0;
};

Vector3d Moved(const Vector3d& p, const Ring& ring) {
  if (ring.borders == 2) return 0.75 * p + 0.125 * ring.along;
  if (ring.borders > 0 || ring.count == 0) return p;  // a corner
  const double n = ring.count;
  const double c = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / n);
  const double others = 0.625 - c * c;
  return (1 - others) * p + others / n * ring.neighbours;
}

SurfaceMesh SubdividedOnce(const SurfaceMesh& mesh) {
  const std::vector<Side> sides = SidesOf(mesh.triangles);
  const Eigen::Index count = mesh.vertices.rows();
  std::vector<Ring> rings(static_cast<std::size_t>(count));
  std::vector<Vector3d> middles;
  Triangles middle_of(mesh.triangles.rows(), 3);  // of the side opposite to each corner
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t end = i + 1;
    while (end < sides.size() && sides[end].ends == sides[i].ends) ++end;
    const auto [a, b] = sides[i].ends;
    const Vector3d p_a = mesh.vertices.row(a), p_b = mesh.vertices.row(b);
    const bool inside = end - i == 2;
    Vector3d middle = (p_a + p_b) / 2;
    if (inside) {
      middle *= 0.75;
      for (std::size_t s = i; s < end; ++s) {
        const int opposite = mesh.triangles(sides[s].triangle, sides[s].corner);
        middle += 0.125 * mesh.vertices.row(opposite).transpose();
      }
    }
    for (const auto& [of, p] : {std::pair(a, p_b), std::pair(b, p_a)}) {
      Ring& ring = rings[static_cast<std::size_t>(of)];
      ring.neighbours += p;
      ++ring.count;
      if (inside) continue;
      ring.along += p;
      ++ring.borders;
    }
    for (std::size_t s = i; s < end; ++s) {
      middle_of(sides[s].triangle, sides[s].corner) =
          static_cast<int>(count) + static_cast<int>(middles.size());
    }
    middles.push_back(middle);
    i = end;
  }

  SurfaceMesh fine;
  fine.vertices.resize(count + static_cast<Eigen::Index>(middles.size()), 3);
  for (Eigen::Index v = 0; v < count; ++v) {
    fine.vertices.row(v) = Moved(mesh.vertices.row(v), rings[static_cast<std::size_t>(v)]);
  }
  for (std::size_t m = 0; m < middles.size(); ++m) {
    fine.vertices.row(count + static_cast<Eigen::Index>(m)) = middles[m];
  }
  const bool textured = mesh.texture_coordinates.rows() > 0;
  fine.triangles.resize(4 * mesh.triangles.rows(), 3);
  if (textured) fine.texture_coordinates.resize(12 * mesh.triangles.rows(), 2);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    // A corner with the middles of its two sides, three times; then the middles.
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      fine.triangles.row(4 * t + k) << mesh.triangles(t, k), middle_of(t, last), middle_of(t, next);
      fine.triangles(4 * t + 3, k) = middle_of(t, k);
      if (!textured) continue;
      const auto uv = mesh.texture_coordinates.middleRows<3>(3 * t);
      const Eigen::Index row = 3 * (4 * t + k);
      fine.texture_coordinates.row(row) = uv.row(k);
      fine.texture_coordinates.row(row + 1) = (uv.row(k) + uv.row(next)) / 2;
      fine.texture_coordinates.row(row + 2) = (uv.row(k) + uv.row(last)) / 2;
      fine.texture_coordinates.row(3 * (4 * t + 3) + k) = (uv.row(next) + uv.row(last)) / 2;
    }
  }
  return fine;
}

}  // namespace

SurfaceMesh Subdivided(const SurfaceMesh& mesh, int times, const char* name) {
  const double triangles = std::pow(4.0, times) * static_cast<double>(mesh.triangles.rows());
  if (times > 0 && triangles > kMaxSubdividedTriangles) {
    throw InputError(std::string(name) + ": " + std::to_string(times) +
                     " subdivisions make more than " + std::to_string(kMaxSubdividedTriangles) +
                     " triangles of its " + std::to_string(mesh.triangles.rows()) +
                     "; ask for fewer");
  }
  SurfaceMesh fine = mesh;
  for (int time = 0; time < times; ++time) fine = SubdividedOnce(fine);
  return fine;
}

}  // namespace hpdm
