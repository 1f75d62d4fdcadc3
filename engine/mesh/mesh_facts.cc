#include "engine/mesh/mesh_facts.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "engine/mesh/mesh_edges.h"

namespace hpdm {
namespace {

// Height over longest side; above the noise of 32-bit coordinates.
constexpr double kNeedle = 1e-6;

void CountEdges(const SurfaceMesh& mesh, MeshFacts* facts) {
  double total = 0;
  int edges = 0;
  facts->min_edge = std::numeric_limits<double>::infinity();
  ForEachEdge(SortedEdgeUses(mesh.triangles), [&](auto first, auto last) {
    const auto uses = last - first;
    if (uses == 1) ++facts->boundary_edges;
    if (uses > 2) ++facts->nonmanifold_edges;
    if (uses == 2 && first->forward == (first + 1)->forward) ++facts->inconsistent_edges;
    const double length = (mesh.vertices.row(first->low) - mesh.vertices.row(first->high)).norm();
    facts->min_edge = std::min(facts->min_edge, length);
    total += length;
    ++edges;
  });
  facts->mean_edge = edges > 0 ? total / edges : 0;
  if (edges == 0) facts->min_edge = 0;
  facts->euler_characteristic -= edges;
}

void CountComponents(const Triangles& triangles, int vertex_count, MeshFacts* facts) {
  DisjointSets sets(vertex_count);
  std::vector<bool> used(static_cast<std::size_t>(vertex_count));
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      used[static_cast<std::size_t>(triangles(t, c))] = true;
      sets.Merge(triangles(t, 0), triangles(t, c));
    }
  }
  for (int v = 0; v < vertex_count; ++v) {
    if (!used[static_cast<std::size_t>(v)]) continue;
    ++facts->euler_characteristic;
    if (sets.Find(v) == v) ++facts->components;
  }
}

void MeasureTriangles(const SurfaceMesh& mesh, MeshFacts* facts) {
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
    const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
    const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
    const double twice_area = (b - a).cross(c - a).norm();
    const double longest =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    facts->area_m2 += twice_area / 2;
    if (!(twice_area > kNeedle * longest)) ++facts->degenerate_triangles;
  }
}

}  // namespace

MeshFacts Scaled(const MeshFacts& facts, double metres_per_unit) {
  MeshFacts scaled = facts;
  scaled.box_min *= metres_per_unit;
  scaled.box_max *= metres_per_unit;
  scaled.min_edge *= metres_per_unit;
  scaled.mean_edge *= metres_per_unit;
  scaled.area_m2 *= metres_per_unit * metres_per_unit;
  scaled.volume_m3 *= metres_per_unit * metres_per_unit * metres_per_unit;
  return scaled;
}

MeshFacts ComputeMeshFacts(const SurfaceMesh& mesh) {
  MeshFacts facts;
  facts.vertices = static_cast<int>(mesh.vertices.rows());
  facts.triangles = static_cast<int>(mesh.triangles.rows());
  if (facts.vertices == 0) return facts;
  facts.box_min = mesh.vertices.colwise().minCoeff();
  facts.box_max = mesh.vertices.colwise().maxCoeff();
  facts.euler_characteristic = facts.triangles;
  CountEdges(mesh, &facts);
  CountComponents(mesh.triangles, facts.vertices, &facts);
  MeasureTriangles(mesh, &facts);
  facts.volume_m3 = EnclosedVolume(mesh.vertices, mesh.triangles);
  if (facts.Closed()) facts.genus = facts.components - facts.euler_characteristic / 2;
  return facts;
}

}  // namespace hpdm
