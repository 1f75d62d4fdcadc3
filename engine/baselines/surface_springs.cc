#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "engine/baselines/mass_spring.h"
#include "engine/mesh/mesh_edges.h"

namespace hpdm {
namespace {

// Neighbours of each vertex in the order of the sorted edges.
std::vector<std::vector<int>> Neighbours(Eigen::Index vertices, const std::vector<EdgeUse>& uses) {
  std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(vertices));
  ForEachEdge(uses, [&](auto first, auto) {
    neighbours[first->low].push_back(first->high);
    neighbours[first->high].push_back(first->low);
  });
  return neighbours;
}

// Returns the neighbour of `v` that lies most nearly opposite to its neighbour `from`, at least 135
// degrees apart; -1 without one.
int Straightest(const SurfaceMesh& rest, int v, int from, const std::vector<int>& neighbours) {
  const auto direction = [&](int to) {
    return (Vector3d(rest.vertices.row(to)) - Vector3d(rest.vertices.row(v))).normalized();
  };
  int straightest = -1;
  double least = std::cos(0.75 * std::numbers::pi);
  for (const int to : neighbours) {
    const double cosine = direction(from).dot(direction(to));
    if (cosine < least) least = cosine, straightest = to;
  }
  return straightest;
}

void KeepFirstOfEachPair(std::vector<Spring>* springs) {
  std::stable_sort(springs->begin(), springs->end(), [](const Spring& s, const Spring& t) {
    return std::pair(s.a, s.b) < std::pair(t.a, t.b);
  });
  springs->erase(
      std::unique(springs->begin(), springs->end(),
                  [](const Spring& s, const Spring& t) { return s.a == t.a && s.b == t.b; }),
      springs->end());
}

}  // namespace

std::vector<Spring> SurfaceSprings(const SurfaceMesh& rest, double modulus, double shear,
                                   double flexion) {
  const auto position = [&](int v) { return Vector3d(rest.vertices.row(v)); };
  Eigen::VectorXd area(rest.triangles.rows());
  const Eigen::VectorXd around = VertexAreas(rest);
  for (int t = 0; t < rest.triangles.rows(); ++t) {
    const Vector3d a = position(rest.triangles(t, 0));
    const Vector3d b = position(rest.triangles(t, 1)), c = position(rest.triangles(t, 2));
    area[t] = (b - a).cross(c - a).norm() / 2;
  }

  std::vector<Spring> springs;
  const auto add = [&](Spring::Kind kind, int a, int b, double stiffness_by_length2) {
    const double length = (position(a) - position(b)).norm();
    if (a == b || length == 0 || stiffness_by_length2 <= 0) return;
    springs.push_back(
        {std::min(a, b), std::max(a, b), length, stiffness_by_length2 / (length * length), kind});
  };

  const std::vector<EdgeUse> uses = SortedEdgeUses(rest.triangles);
  ForEachEdge(uses, [&](auto first, auto last) {
    double both = 0;
    for (auto use = first; use != last; ++use) both += area[use->triangle];
    add(Spring::Kind::kStructural, first->low, first->high, modulus * both);
    if (shear <= 0 || last - first != 2) return;
    std::array<int, 2> opposite;
    for (int side = 0; side < 2; ++side) {
      const int t = first[side].triangle;
      opposite[side] = rest.triangles(t, 0) + rest.triangles(t, 1) + rest.triangles(t, 2) -
                       first->low - first->high;
    }
    add(Spring::Kind::kShear, opposite[0], opposite[1], shear * modulus * both);
  });

  if (flexion > 0) {
    const std::vector<std::vector<int>> neighbours = Neighbours(rest.vertices.rows(), uses);
    for (int v = 0; v < rest.vertices.rows(); ++v) {
      for (const int from : neighbours[v]) {
        const int straightest = Straightest(rest, v, from, neighbours[v]);
        if (straightest < 0) continue;
        // With even triangles, v's thirds of six triangles equal the area of two.
        add(Spring::Kind::kFlexion, from, straightest, flexion * modulus * around[v]);
      }
    }
  }

  KeepFirstOfEachPair(&springs);
  return springs;
}

}  // namespace hpdm
