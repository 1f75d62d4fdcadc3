#include "engine/mesh/mesh_subdivision.h"

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/mesh_edges.h"

namespace hpdm {
namespace {

// The neighbours of a vertex.
struct Ring {
  Vector3d neighbours = Vector3d::Zero();  // sum of their positions, m
  int count = 0;
  Vector3d along = Vector3d::Zero();  // sum over the neighbours along border edges, m
  int borders = 0;                    // number of border edges
};

Vector3d Moved(const Vector3d& p, const Ring& ring) {
  if (ring.borders == 2) return 0.75 * p + 0.125 * ring.along;
  if (ring.borders > 0 || ring.count == 0) return p;  // corners of the border stay
  const double n = ring.count;
  const double c = 0.375 + 0.25 * std::cos(2 * std::numbers::pi / n);
  const double others = 0.625 - c * c;
  return (1 - others) * p + others / n * ring.neighbours;
}

// Computes the vertices of the finer mesh: the moved ones, then one for each edge. Sets middles(t,
// k) to the number of the new vertex on the side opposite to corner k of triangle t.
Points FineVertices(const SurfaceMesh& mesh, Triangles* middles) {
  const Eigen::Index count = mesh.vertices.rows();
  std::vector<Ring> rings(ToSize(count));
  std::vector<Vector3d> added;
  ForEachEdge(SortedEdgeUses(mesh.triangles), [&](auto first, auto last) {
    const int a = first->low, b = first->high;
    const Vector3d p_a = mesh.vertices.row(a), p_b = mesh.vertices.row(b);
    const bool inside = last - first == 2;
    Vector3d middle = (p_a + p_b) / 2;
    if (inside) middle *= 0.75;
    for (auto use = first; use != last; ++use) {
      (*middles)(use->triangle, use->opposite) =
          static_cast<int>(count) + static_cast<int>(added.size());
      const int opposite = mesh.triangles(use->triangle, use->opposite);
      if (inside) middle += 0.125 * mesh.vertices.row(opposite).transpose();
    }
    added.push_back(middle);
    for (const auto& [of, p] : {std::pair(a, p_b), std::pair(b, p_a)}) {
      Ring& ring = rings[ToSize(of)];
      ring.neighbours += p;
      ++ring.count;
      if (inside) continue;
      ring.along += p;
      ++ring.borders;
    }
  });

  Points fine(count + static_cast<Eigen::Index>(added.size()), 3);
  for (Eigen::Index v = 0; v < count; ++v) {
    fine.row(v) = Moved(mesh.vertices.row(v), rings[ToSize(v)]);
  }
  for (std::size_t m = 0; m < added.size(); ++m) {
    fine.row(count + static_cast<Eigen::Index>(m)) = added[m];
  }
  return fine;
}

SurfaceMesh SubdividedOnce(const SurfaceMesh& mesh) {
  Triangles middles(mesh.triangles.rows(), 3);
  SurfaceMesh fine;
  fine.vertices = FineVertices(mesh, &middles);
  const bool textured = mesh.texture_coordinates.rows() > 0;
  fine.triangles.resize(4 * mesh.triangles.rows(), 3);
  if (textured) fine.texture_coordinates.resize(12 * mesh.triangles.rows(), 2);
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    // Three triangles of a corner and the middles of its two sides, then one of the three middles.
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      fine.triangles.row(4 * t + k) << mesh.triangles(t, k), middles(t, last), middles(t, next);
      fine.triangles(4 * t + 3, k) = middles(t, k);
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
    throw InputError(std::string(name) + ": " + std::to_string(times) + " subdivisions of " +
                     std::to_string(mesh.triangles.rows()) + " triangles make more than " +
                     std::to_string(kMaxSubdividedTriangles) + "; use fewer subdivisions");
  }
  SurfaceMesh fine = mesh;
  for (int time = 0; time < times; ++time) fine = SubdividedOnce(fine);
  return fine;
}

}  // namespace hpdm
