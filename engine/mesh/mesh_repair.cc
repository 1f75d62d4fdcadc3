#include "engine/mesh/mesh_repair.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

#include "engine/mesh/mesh_orientation.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;

/// Joins points within a tolerance of an earlier one. The cells of its hash grid are four
/// tolerances wide: most points search one cell, and a cell holds at most about a hundred points.
class Welder {
 public:
  Welder(const Points& points, double tolerance)
      : points_(points),
        tolerance_(tolerance),
        cell_(4 * tolerance),
        origin_(points.colwise().minCoeff()),
        heads_(std::bit_ceil(ToSize(2 * points.rows())), -1),
        next_(ToSize(points.rows()), -1) {}

  /// Returns for each point the first one that it is joined to (itself if none).
  std::vector<int> Weld() {
    std::vector<int> first(ToSize(points_.rows()));
    for (int v = 0; v < static_cast<int>(points_.rows()); ++v) {
      const int found = FindNear(v);
      first[ToSize(v)] = found >= 0 ? found : v;
      if (found < 0) Insert(v);
    }
    return first;
  }

 private:
  // Doubles, because the cell numbers may exceed every integer type. Adding zero turns -0 into +0.
  Vector3d CellOf(const Vector3d& p) const { return ((p - origin_) / cell_).array().floor() + 0.0; }

  int& Head(const Vector3d& cell) {
    std::uint64_t hash = 0;
    for (int d = 0; d < 3; ++d) {
      hash = (hash ^ std::bit_cast<std::uint64_t>(cell[d])) * 0x9E3779B97F4A7C15u;
      hash ^= hash >> 29;
    }
    return heads_[hash & (heads_.size() - 1)];
  }

  int FindNear(int v) {
    const Vector3d p = points_.row(v);
    const Vector3d reach = Vector3d::Constant(tolerance_);
    const Vector3d low = CellOf(p - reach), high = CellOf(p + reach);
    int nearest = -1;
    for (int corner = 0; corner < 8; ++corner) {  // at most two cells along each axis
      Vector3d cell = low;
      bool again = false;
      for (int d = 0; d < 3; ++d) {
        if ((corner >> d & 1) == 0) continue;
        again = again || high[d] == low[d];
        cell[d] = high[d];
      }
      if (again) continue;
      for (int other = Head(cell); other >= 0; other = next_[ToSize(other)]) {
        const bool near = (points_.row(other).transpose() - p).norm() <= tolerance_;
        if (near && (nearest < 0 || other < nearest)) nearest = other;
      }
    }
    return nearest;
  }

  void Insert(int v) {
    int& head = Head(CellOf(points_.row(v)));
    next_[ToSize(v)] = head;
    head = v;
  }

  const Points& points_;
  double tolerance_, cell_;
  Vector3d origin_;
  std::vector<int> heads_, next_;
};

/// Replaces the corners of each triangle by the vertices that they are joined to. Returns how many
/// vertices were joined to another one.
int JoinTo(const std::vector<int>& first, Triangles* triangles) {
  int joined = 0;
  for (std::size_t v = 0; v < first.size(); ++v) joined += ToSize(first[v]) != v;
  for (Index t = 0; t < triangles->rows(); ++t) {
    for (int c = 0; c < 3; ++c) (*triangles)(t, c) = first[ToSize((*triangles)(t, c))];
  }
  return joined;
}

double WeldTolerance(const SurfaceMesh& mesh) {
  const Points& p = mesh.vertices;
  const double by_size = kWeldTolerance * (p.colwise().maxCoeff() - p.colwise().minCoeff()).norm();
  std::vector<double> edges;  // those with a length
  edges.reserve(ToSize(3 * mesh.triangles.rows()));
  for (Index t = 0; t < mesh.triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) {
      const auto a = p.row(mesh.triangles(t, c)), b = p.row(mesh.triangles(t, (c + 1) % 3));
      if (const double length = (a - b).norm(); length > 0) edges.push_back(length);
    }
  }
  if (edges.empty()) return by_size;
  const auto usual = edges.begin() + static_cast<std::ptrdiff_t>(edges.size() * 9 / 10);
  std::nth_element(edges.begin(), usual, edges.end());
  return std::min(by_size, kWeldEdgeShare * *usual);
}

/// Returns how many vertices were joined to another one.
int WeldVertices(SurfaceMesh* mesh) {
  const double tolerance = WeldTolerance(*mesh);
  const std::vector<int> first = tolerance > 0 ? Welder(mesh->vertices, tolerance).Weld()
                                               : std::vector<int>(ToSize(mesh->vertices.rows()), 0);
  return JoinTo(first, &mesh->triangles);
}

void DropTriangles(SurfaceMesh* mesh, MeshRepairs* repairs) {
  Triangles* triangles = &mesh->triangles;
  TextureCoordinates* uv = &mesh->texture_coordinates;
  struct Entry {
    std::array<int, 3> corners;  // ascending
    int triangle;
    auto operator<=>(const Entry&) const = default;
  };
  std::vector<Entry> entries;
  entries.reserve(ToSize(triangles->rows()));
  for (int t = 0; t < static_cast<int>(triangles->rows()); ++t) {
    std::array<int, 3> corners = {(*triangles)(t, 0), (*triangles)(t, 1), (*triangles)(t, 2)};
    std::sort(corners.begin(), corners.end());
    if (corners[0] == corners[1] || corners[1] == corners[2]) {
      ++repairs->degenerate_triangles;
    } else {
      entries.push_back({corners, t});
    }
  }
  std::sort(entries.begin(), entries.end());
  std::vector<int> kept;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i > 0 && entries[i].corners == entries[i - 1].corners) {
      ++repairs->duplicate_triangles;
    } else {
      kept.push_back(entries[i].triangle);
    }
  }
  std::sort(kept.begin(), kept.end());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    const Index t = static_cast<Index>(i);
    triangles->row(t) = triangles->row(kept[i]).eval();
    if (uv->rows() > 0) uv->middleRows<3>(3 * t) = uv->middleRows<3>(3 * kept[i]).eval();
  }
  const Index count = static_cast<Index>(kept.size());
  triangles->conservativeResize(count, 3);
  if (uv->rows() > 0) uv->conservativeResize(3 * count, 2);
}

/// Returns how many vertices were dropped, welded ones included.
int DropVertices(SurfaceMesh* mesh) {
  std::vector<int> number(ToSize(mesh->vertices.rows()), -1);
  for (Index t = 0; t < mesh->triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) number[ToSize(mesh->triangles(t, c))] = 0;
  }
  int count = 0;
  for (Index v = 0; v < mesh->vertices.rows(); ++v) {
    if (number[ToSize(v)] < 0) continue;
    mesh->vertices.row(count) = mesh->vertices.row(v).eval();
    number[ToSize(v)] = count++;
  }
  const int dropped = static_cast<int>(mesh->vertices.rows()) - count;
  mesh->vertices.conservativeResize(count, 3);
  for (Index t = 0; t < mesh->triangles.rows(); ++t) {
    for (int c = 0; c < 3; ++c) mesh->triangles(t, c) = number[ToSize(mesh->triangles(t, c))];
  }
  return dropped;
}

}  // namespace

std::vector<std::pair<std::string, int>> MeshRepairs::List() const {
  std::vector<std::pair<std::string, int>> list = {{"welded_vertices", welded_vertices},
                                                   {"degenerate_triangles", degenerate_triangles},
                                                   {"duplicate_triangles", duplicate_triangles},
                                                   {"unreferenced_vertices", unreferenced_vertices},
                                                   {"reoriented_triangles", reoriented_triangles}};
  std::erase_if(list, [](const auto& repair) { return repair.second == 0; });
  return list;
}

void JoinIdenticalVertices(SurfaceMesh* mesh) {
  const Points& p = mesh->vertices;
  const auto place = [&p](int v) { return std::make_tuple(p(v, 0), p(v, 1), p(v, 2)); };
  std::vector<int> order(ToSize(p.rows()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int v, int w) {
    return std::make_tuple(place(v), v) < std::make_tuple(place(w), w);
  });
  std::vector<int> first(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool repeats = i > 0 && place(order[i]) == place(order[i - 1]);
    first[ToSize(order[i])] = repeats ? first[ToSize(order[i - 1])] : order[i];
  }
  JoinTo(first, &mesh->triangles);
  DropVertices(mesh);
}

MeshRepairs RepairMesh(SurfaceMesh* mesh) {
  MeshRepairs repairs;
  // Dropped edges change the tolerance, so the passes repeat until nothing changes.
  for (bool changed = true; changed && mesh->vertices.rows() > 0;) {
    const Index triangles = mesh->triangles.rows();
    const int welded = WeldVertices(mesh);
    DropTriangles(mesh, &repairs);
    repairs.welded_vertices += welded;
    repairs.unreferenced_vertices += DropVertices(mesh) - welded;
    changed = welded > 0 || mesh->triangles.rows() < triangles;
  }
  repairs.reoriented_triangles = OrientTriangles(mesh);
  return repairs;
}

}  // namespace hpdm
