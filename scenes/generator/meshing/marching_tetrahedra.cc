#include "scenes/generator/meshing/marching_tetrahedra.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {
namespace {

/// Corners of a cube are bits (x = 1, y = 2, z = 4); each tetrahedron walks from 0 to 7 along the
/// axes in one of their six orders.
constexpr std::array<std::array<int, 4>, 6> kTetrahedra = {
    {{0, 1, 3, 7}, {0, 1, 5, 7}, {0, 2, 3, 7}, {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 4, 6, 7}}};

class Marcher {
 public:
  Marcher(const ImplicitShape& shape, double level, double spacing) : spacing_(spacing) {
    const Bounds box = shape.bounds();
    origin_ = box.min;
    for (int k = 0; k < 3; ++k) {
      size_[k] = static_cast<int>(std::ceil((box.max[k] - box.min[k]) / spacing)) + 1;
    }
    const int node_count = size_[0] * size_[1] * size_[2];
    field_.resize(node_count);
    for (int n = 0; n < node_count; ++n) {
      field_[n] = shape.Sample(Position(n)).value - level;
      if (field_[n] < 0 && OnBorder(n)) {
        throw InputError("implicit shape: the surface leaves its bounds; enlarge bounds()");
      }
    }
    edge_vertices_.assign(static_cast<std::size_t>(node_count) * 8, -1);
  }

  SurfaceMesh Run() {
    for (int z = 0; z + 1 < size_[2]; ++z) {
      for (int y = 0; y + 1 < size_[1]; ++y) {
        for (int x = 0; x + 1 < size_[0]; ++x) {
          for (const std::array<int, 4>& tetrahedron : kTetrahedra)
            March(Node(x, y, z), tetrahedron);
        }
      }
    }
    if (triangles_.empty()) {
      throw InputError("implicit shape: no surface at this level; check bounds() and the spacing");
    }
    SurfaceMesh mesh;
    mesh.vertices.resize(vertices_.size(), 3);
    for (std::size_t v = 0; v < vertices_.size(); ++v) mesh.vertices.row(v) = vertices_[v];
    mesh.triangles.resize(triangles_.size(), 3);
    for (std::size_t t = 0; t < triangles_.size(); ++t) {
      for (int k = 0; k < 3; ++k) mesh.triangles(t, k) = triangles_[t][k];
    }
    return mesh;
  }

 private:
  int Node(int x, int y, int z) const { return (z * size_[1] + y) * size_[0] + x; }
  int Corner(int node, int bits) const {
    return node + Node(bits & 1, (bits >> 1) & 1, (bits >> 2) & 1);
  }
  std::array<int, 3> Place(int node) const {
    return {node % size_[0], node / size_[0] % size_[1], node / (size_[0] * size_[1])};
  }
  Vector3d Position(int node) const {
    const std::array<int, 3> place = Place(node);
    return origin_ + spacing_ * Vector3d(place[0], place[1], place[2]);
  }
  bool OnBorder(int node) const {
    const std::array<int, 3> place = Place(node);
    for (int k = 0; k < 3; ++k) {
      if (place[k] == 0 || place[k] == size_[k] - 1) return true;
    }
    return false;
  }

  /// The surface's vertex on the edge between two corners of the cube at `node`, the bits of the
  /// first being part of the second's.
  int EdgeVertex(int node, int first, int second) {
    const int a = Corner(node, first), b = Corner(node, second);
    int& vertex = edge_vertices_[static_cast<std::size_t>(a) * 8 + (second - first)];
    if (vertex < 0) {
      // The vertex keeps away from the edge's ends, so that no triangle is degenerate.
      const double t = std::clamp(field_[a] / (field_[a] - field_[b]), 0.05, 0.95);
      vertex = static_cast<int>(vertices_.size());
      vertices_.push_back(Position(a) + t * (Position(b) - Position(a)));
    }
    return vertex;
  }

  void March(int node, const std::array<int, 4>& tetrahedron) {
    std::array<int, 4> inside, outside;
    int inside_count = 0, outside_count = 0;
    for (const int bits : tetrahedron) {
      if (field_[Corner(node, bits)] < 0) {
        inside[inside_count++] = bits;
      } else {
        outside[outside_count++] = bits;
      }
    }
    if (inside_count == 0 || outside_count == 0) return;
    const auto vertex = [this, node](int p, int q) {
      return EdgeVertex(node, std::min(p, q), std::max(p, q));
    };
    const Vector3d outwards =
        Position(Corner(node, outside[0])) - Position(Corner(node, inside[0]));
    if (inside_count == 2) {
      const int a = vertex(inside[0], outside[0]);
      const int b = vertex(inside[0], outside[1]);
      const int c = vertex(inside[1], outside[1]);
      const int d = vertex(inside[1], outside[0]);
      Add(a, b, c, outwards);
      Add(a, c, d, outwards);
      return;
    }
    // One statement per vertex, so that their order does not depend on the compiler.
    const bool one_inside = inside_count == 1;
    std::array<int, 3> corners;
    for (int k = 0; k < 3; ++k) {
      corners[k] = one_inside ? vertex(inside[0], outside[k]) : vertex(inside[k], outside[0]);
    }
    Add(corners[0], corners[1], corners[2], outwards);
  }

  void Add(int a, int b, int c, const Vector3d& outwards) {
    const Vector3d normal = (vertices_[b] - vertices_[a]).cross(vertices_[c] - vertices_[a]);
    if (normal.dot(outwards) < 0) std::swap(b, c);
    triangles_.push_back({a, b, c});
  }

  double spacing_;
  Vector3d origin_;
  std::array<int, 3> size_;
  std::vector<double> field_;       ///< At the nodes, minus the level.
  std::vector<int> edge_vertices_;  ///< Index: node and direction; -1 for none.
  std::vector<Vector3d> vertices_;
  std::vector<std::array<int, 3>> triangles_;
};

}  // namespace

SurfaceMesh MarchTetrahedra(const ImplicitShape& shape, double level, double spacing) {
  return Marcher(shape, level, spacing).Run();
}

}  // namespace hpdm
