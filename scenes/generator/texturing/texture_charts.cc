#include "scenes/generator/texturing/texture_charts.h"

#include <algorithm>
#include <array>
#include <map>
#include <utility>

#include "engine/mesh/mesh_edges.h"

namespace hpdm {
namespace {

using Index = Eigen::Index;

/// Smallest cosine between a triangle's normal and its chart's axis. Below it a projection would
/// stretch texels visibly.
constexpr double kObliqueCosine = 0.3;
/// A chart with less than this part of the surface joins a neighbour.
constexpr double kSmallArea = 0.01;

class ChartCutter {
 public:
  explicit ChartCutter(const SurfaceMesh& mesh) : mesh_(mesh) {
    const Index count = mesh.triangles.rows();
    normals_.resize(count, 3);
    areas_.resize(ToSize(count));
    for (Index t = 0; t < count; ++t) {
      const Vector3d a = mesh.vertices.row(mesh.triangles(t, 0));
      const Vector3d b = mesh.vertices.row(mesh.triangles(t, 1));
      const Vector3d c = mesh.vertices.row(mesh.triangles(t, 2));
      const Vector3d twice_area = (b - a).cross(c - a);
      const double length = twice_area.norm();
      areas_[ToSize(t)] = length / 2;
      normals_.row(t) = length > 0 ? Vector3d(twice_area / length) : Vector3d(0, 0, 1);
    }
    neighbours_.assign(ToSize(count), {-1, -1, -1});
    std::vector<int> known(ToSize(count));
    ForEachEdge(SortedEdgeUses(mesh.triangles), [&](auto first, auto last) {
      if (last - first != 2) return;
      const int t = first->triangle, other = (first + 1)->triangle;
      neighbours_[ToSize(t)][ToSize(known[ToSize(t)]++)] = other;
      neighbours_[ToSize(other)][ToSize(known[ToSize(other)]++)] = t;
    });
  }

  std::vector<TextureChart> Cut() {
    TakeNearestAxes();
    for (int round = 0; round < 8 && FollowNeighbours(); ++round) {
    }
    for (int round = 0; round < 8 && JoinSmallCharts(); ++round) {
    }
    const std::vector<int> chart = Components();
    std::map<int, TextureChart> charts;
    for (Index t = 0; t < mesh_.triangles.rows(); ++t) {
      TextureChart& own = charts[chart[ToSize(t)]];
      own.axis = axis_[ToSize(t)];
      own.triangles.push_back(static_cast<int>(t));
    }
    std::vector<TextureChart> list;
    for (auto& [root, own] : charts) list.push_back(std::move(own));
    return list;
  }

 private:
  double Cosine(Index t, int axis) const { return normals_.row(t).dot(ChartDirection(axis)); }

  void TakeNearestAxes() {
    axis_.resize(areas_.size());
    for (Index t = 0; t < normals_.rows(); ++t) {
      for (int axis = 1; axis < 6; ++axis) {
        if (Cosine(t, axis) > Cosine(t, axis_[ToSize(t)])) axis_[ToSize(t)] = axis;
      }
    }
  }

  /// Smooths the charts' borders. Returns false if nothing changed.
  bool FollowNeighbours() {
    bool changed = false;
    for (Index t = 0; t < normals_.rows(); ++t) {
      const auto& [a, b, c] = neighbours_[ToSize(t)];
      for (const auto& [i, j] : {std::pair(a, b), std::pair(b, c), std::pair(c, a)}) {
        if (i < 0 || j < 0 || axis_[ToSize(i)] != axis_[ToSize(j)]) continue;
        if (axis_[ToSize(i)] == axis_[ToSize(t)] || Cosine(t, axis_[ToSize(i)]) < kObliqueCosine)
          continue;
        axis_[ToSize(t)] = axis_[ToSize(i)];
        changed = true;
      }
    }
    return changed;
  }

  /// Returns for each triangle the first one of its chart.
  std::vector<int> Components() const {
    DisjointSets sets(static_cast<int>(axis_.size()));
    for (std::size_t t = 0; t < axis_.size(); ++t) {
      for (const int other : neighbours_[t]) {
        if (other >= 0 && axis_[ToSize(other)] == axis_[t]) sets.Merge(static_cast<int>(t), other);
      }
    }
    std::vector<int> root(axis_.size());
    for (std::size_t t = 0; t < root.size(); ++t) root[t] = sets.Find(static_cast<int>(t));
    return root;
  }

  /// Gives small charts the axis of the neighbour with which they share the most sides and that
  /// sees all their triangles. Returns false if no chart changed.
  bool JoinSmallCharts() {
    const std::vector<int> chart = Components();
    std::map<int, double> area;
    double whole = 0;
    for (std::size_t t = 0; t < chart.size(); ++t) {
      area[chart[t]] += areas_[t];
      whole += areas_[t];
    }
    std::map<int, std::vector<int>> small;
    for (std::size_t t = 0; t < chart.size(); ++t) {
      if (area[chart[t]] < kSmallArea * whole) small[chart[t]].push_back(static_cast<int>(t));
    }
    bool changed = false;
    for (const auto& [root, triangles] : small) {
      std::array<int, 6> sides{};
      for (const int t : triangles) {
        for (const int other : neighbours_[ToSize(t)]) {
          if (other >= 0 && chart[ToSize(other)] != root) ++sides[ToSize(axis_[ToSize(other)])];
        }
      }
      int best = -1;
      for (int axis = 0; axis < 6; ++axis) {
        const bool sees_all = std::all_of(triangles.begin(), triangles.end(), [&](int t) {
          return Cosine(t, axis) >= 0.5 * kObliqueCosine;
        });
        if (sides[ToSize(axis)] > 0 && sees_all && axis != axis_[ToSize(root)] &&
            (best < 0 || sides[ToSize(axis)] > sides[ToSize(best)])) {
          best = axis;
        }
      }
      if (best < 0) continue;
      for (const int t : triangles) axis_[ToSize(t)] = best;
      changed = true;
    }
    return changed;
  }

  const SurfaceMesh& mesh_;
  Points normals_;
  std::vector<double> areas_;
  std::vector<std::array<int, 3>> neighbours_;
  std::vector<int> axis_;
};

}  // namespace

Vector3d ChartDirection(int axis) { return (axis % 2 == 0 ? 1 : -1) * Vector3d::Unit(axis / 2); }

Eigen::Vector2d ChartPlane(int axis, const Vector3d& p) {
  const double right = p[(axis / 2 + 1) % 3], up = p[(axis / 2 + 2) % 3];
  return {axis % 2 == 0 ? right : -right, up};
}

std::vector<TextureChart> CutIntoCharts(const SurfaceMesh& mesh) { return ChartCutter(mesh).Cut(); }

}  // namespace hpdm
