#include "render/tissue/mesh_levels.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <tuple>
#include <utility>

#include "engine/mesh/closest_point.h"
#include "engine/mesh/mesh_edges.h"
#include "engine/mesh/quadric.h"

namespace hpdm {
namespace {

constexpr int kMinLevelTriangles = 100;
constexpr int kMaxLevels = 12;

// Weight of the squared length in a collapse's cost: an edge in a flat part costs as much as a
// deviation of a thirtieth of its length.
constexpr double kLengthCost = 1e-3;

// No collapse makes triangles with a smaller Evenness.
constexpr double kMinEvenness = 0.03;

// Returns sin^2 of the smallest angle; 3/4 for an equilateral triangle.
double Evenness(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const double area2 = (b - a).cross(c - a).squaredNorm();
  const double ab = (b - a).squaredNorm(), bc = (c - b).squaredNorm(), ca = (a - c).squaredNorm();
  const double longest = std::max({ab, bc, ca});
  // The smallest angle lies opposite to the shortest side.
  const double others = ab * bc * ca / std::min({ab, bc, ca});
  return longest > 0 && others > 0 ? area2 / others : 0;
}

struct Collapse {
  double cost;  // m^4
  int gone, kept;
  int version_gone, version_kept;
  // Cheapest first, then by number, so that the order does not depend on the queue's
  // implementation.
  bool operator<(const Collapse& other) const {
    return std::tie(cost, gone, kept, version_gone, version_kept) >
           std::tie(other.cost, other.gone, other.kept, other.version_gone, other.version_kept);
  }
};

class Simplifier {
 public:
  Simplifier(const SeamedMesh& mesh, const Points& rest)
      : triangles_(mesh.triangles),
        count_(static_cast<int>(mesh.triangles.rows())),
        alive_(static_cast<std::size_t>(count_), true),
        on_(static_cast<std::size_t>(count_)),
        positions_(rest.rows() + static_cast<Eigen::Index>(mesh.copies.size()), 3) {
    positions_.topRows(rest.rows()) = rest;
    for (std::size_t c = 0; c < mesh.copies.size(); ++c) {
      positions_.row(rest.rows() + static_cast<Eigen::Index>(c)) = rest.row(mesh.copies[c]);
    }
    const auto vertices = static_cast<std::size_t>(positions_.rows());
    stars_.resize(vertices);
    quadrics_.resize(vertices);
    versions_.assign(vertices, 0);
    stays_.assign(vertices, false);
    for (int t = 0; t < count_; ++t) {
      const Vector3d area = Area(triangles_.row(t));
      const double twice = area.norm();
      for (int k = 0; k < 3; ++k) {
        const int v = triangles_(t, k);
        stars_[v].push_back(t);
        if (twice > 0) quadrics_[v].AddPlane(area / twice, At(v), twice / 6);
      }
    }
    KeepBorders();
    for (int v = 0; v < static_cast<int>(vertices); ++v) {
      if (!stays_[v]) PushFrom(v);
    }
  }

  // Collapses edges until at most `triangles` are left; false if that is impossible.
  bool Reduce(int triangles) {
    while (count_ > triangles && !queue_.empty()) {
      const Collapse next = queue_.top();
      queue_.pop();
      if (versions_[next.gone] != next.version_gone || versions_[next.kept] != next.version_kept) {
        continue;
      }
      if (IsSound(next.gone, next.kept)) Apply(next.gone, next.kept);
    }
    return count_ <= triangles;
  }

  MeshLevel Level() const {
    MeshLevel level;
    level.triangles.resize(count_, 3);
    double edges = 0;
    Eigen::Index next = 0;
    for (std::size_t t = 0; t < alive_.size(); ++t) {
      if (!alive_[t]) continue;
      const Eigen::RowVector3i corners = triangles_.row(static_cast<Eigen::Index>(t));
      level.triangles.row(next++) = corners;
      for (int k = 0; k < 3; ++k) edges += (At(corners[k]) - At(corners[(k + 1) % 3])).norm();
      for (const auto& [vertex, weights] : on_[t]) {
        MeshLevel::Place place{vertex, {corners[0], corners[1], corners[2]}, {}};
        for (int k = 0; k < 3; ++k) place.weights[k] = static_cast<float>(weights[k]);
        level.dropped.push_back(place);
      }
    }
    level.mean_edge = edges / (3.0 * std::max(count_, 1));
    return level;
  }
  Vector3d At(int vertex) const { return positions_.row(vertex); }
  int count() const { return count_; }

 private:
  // Returns the normal with the length of twice the area.
  Vector3d Area(const Eigen::RowVector3i& corners) const {
    const Vector3d a = At(corners[0]);
    return (At(corners[1]) - a).cross(At(corners[2]) - a);
  }

  // Keeps the vertices of edges that do not join exactly two triangles: borders, and seams, where
  // the drawn mesh is cut open.
  void KeepBorders() {
    ForEachEdge(SortedEdgeUses(triangles_), [&](auto first, auto last) {
      if (last - first != 2) stays_[first->low] = stays_[first->high] = true;
    });
  }

  // Fills neighbours_, ascending.
  void CollectNeighbours(int v) {
    neighbours_.clear();
    for (const int t : stars_[v]) {
      for (int k = 0; k < 3; ++k) {
        if (triangles_(t, k) != v) neighbours_.push_back(triangles_(t, k));
      }
    }
    std::sort(neighbours_.begin(), neighbours_.end());
    neighbours_.erase(std::unique(neighbours_.begin(), neighbours_.end()), neighbours_.end());
  }

  void Push(int gone, int kept) {
    Quadric sum = quadrics_[gone];
    sum += quadrics_[kept];
    const double length2 = (At(gone) - At(kept)).squaredNorm();
    const double cost = std::max(sum.Error(At(kept)), 0.0) + kLengthCost * sum.weight() * length2;
    queue_.push({cost, gone, kept, versions_[gone], versions_[kept]});
  }

  void PushFrom(int v) {
    CollectNeighbours(v);
    for (const int w : neighbours_) Push(v, w);
  }

  // True if two triangles vanish, the others neither flip nor become slivers, and no edge gets a
  // third triangle.
  bool IsSound(int gone, int kept) {
    CollectNeighbours(gone);
    others_ = neighbours_;
    CollectNeighbours(kept);
    std::size_t common = 0;
    for (const int w : others_) {
      common += std::binary_search(neighbours_.begin(), neighbours_.end(), w);
    }
    if (common != 2 || stars_[gone].size() < 4) return false;
    double before_least = 1, after_least = 1;
    for (const int t : stars_[gone]) {
      Eigen::RowVector3i corners = triangles_.row(t);
      const Vector3d before = Area(corners);
      before_least =
          std::min(before_least, Evenness(At(corners[0]), At(corners[1]), At(corners[2])));
      if ((corners.array() == kept).any()) continue;
      for (int k = 0; k < 3; ++k) {
        if (corners[k] == gone) corners[k] = kept;
      }
      const Vector3d after = Area(corners);
      if (before.dot(after) <= 0.5 * before.norm() * after.norm()) return false;
      after_least = std::min(after_least, Evenness(At(corners[0]), At(corners[1]), At(corners[2])));
    }
    return after_least >= std::min(kMinEvenness, before_least);
  }

  void Apply(int gone, int kept) {
    moving_.clear();
    moving_.push_back(gone);
    for (const int t : stars_[gone]) {
      for (const auto& [vertex, weights] : on_[t]) moving_.push_back(vertex);
      on_[t].clear();
    }
    remaining_.clear();
    for (const int t : stars_[gone]) {
      if ((triangles_.row(t).array() == kept).any()) {
        alive_[t] = false;
        --count_;
        for (int k = 0; k < 3; ++k) {
          const int v = triangles_(t, k);
          if (v != gone) std::erase(stars_[v], t);
        }
        continue;
      }
      for (int k = 0; k < 3; ++k) {
        if (triangles_(t, k) == gone) triangles_(t, k) = kept;
      }
      stars_[kept].push_back(t);
      remaining_.push_back(t);
    }
    stars_[gone].clear();
    quadrics_[kept] += quadrics_[gone];
    ++versions_[gone];
    ++versions_[kept];
    for (const int vertex : moving_) Settle(vertex);
    CollectNeighbours(kept);
    others_ = neighbours_;
    for (const int w : others_) {
      if (!stays_[kept]) Push(kept, w);
      if (!stays_[w]) Push(w, kept);
    }
  }

  // Places a dropped vertex on the nearest of the remaining triangles.
  void Settle(int vertex) {
    const Vector3d p = At(vertex);
    double nearest2 = std::numeric_limits<double>::infinity();
    std::pair<int, Vector3d> best{-1, Vector3d::Zero()};
    for (const int t : remaining_) {
      const TrianglePoint closest =
          ClosestOnTriangle(p, At(triangles_(t, 0)), At(triangles_(t, 1)), At(triangles_(t, 2)));
      const double distance2 = (closest.point - p).squaredNorm();
      if (distance2 >= nearest2) continue;
      nearest2 = distance2;
      best = {t, closest.barycentric};
    }
    on_[static_cast<std::size_t>(best.first)].push_back({vertex, best.second});
  }

  Triangles triangles_;
  int count_;
  std::vector<bool> alive_;
  std::vector<std::vector<std::pair<int, Vector3d>>> on_;  // dropped vertices by triangle
  Points positions_;                                       // R x 3, m
  std::vector<std::vector<int>> stars_;                    // triangles around each vertex
  std::vector<Quadric> quadrics_;
  std::vector<int> versions_;
  std::vector<bool> stays_;
  std::priority_queue<Collapse> queue_;
  std::vector<int> neighbours_, others_, moving_, remaining_;  // scratch
};

// Interpolates `values` at the place of a dropped vertex.
template <typename Rows>
auto AtPlace(const MeshLevel::Place& place, const Rows& values) {
  return (place.weights[0] * values.row(place.corners[0]) +
          place.weights[1] * values.row(place.corners[1]) +
          place.weights[2] * values.row(place.corners[2]))
      .eval();
}

// Returns the shift of a dropped vertex's texture, m: the way on the place's triangle that
// corresponds to the difference of the texture coordinates.
double TextureDrift(const MeshLevel::Place& place, const SeamedMesh& mesh, const Points& drawn,
                    double metres_per_uv) {
  const auto uv = [&](int vertex) {
    return Eigen::Vector2d(mesh.texture_coordinates.row(vertex).cast<double>());
  };
  const Eigen::Vector2d off =
      uv(place.vertex) - AtPlace(place, mesh.texture_coordinates).transpose().cast<double>();
  Eigen::Matrix2d sides;
  sides << uv(place.corners[1]) - uv(place.corners[0]), uv(place.corners[2]) - uv(place.corners[0]);
  constexpr double kFlat = 1e-3;  // sine of the angle in a degenerate triangle of the texture
  if (!(std::abs(sides.determinant()) > kFlat * sides.col(0).norm() * sides.col(1).norm())) {
    return metres_per_uv * off.norm();
  }
  const Eigen::Vector2d along = sides.inverse() * off;
  return (along[0] * (drawn.row(place.corners[1]) - drawn.row(place.corners[0])) +
          along[1] * (drawn.row(place.corners[2]) - drawn.row(place.corners[0])))
      .norm();
}

double RestError(const MeshLevel& level, const SeamedMesh& mesh, const Points& rest,
                 double metres_per_uv) {
  Points drawn(rest.rows() + static_cast<Eigen::Index>(mesh.copies.size()), 3);
  drawn << rest, rest(mesh.copies, Eigen::all);
  double drift2 = 0;
  for (const MeshLevel::Place& place : level.dropped) {
    const double drift = TextureDrift(place, mesh, drawn, metres_per_uv);
    drift2 += drift * drift;
  }
  drift2 /= static_cast<double>(std::max<std::size_t>(level.dropped.size(), 1));
  return std::max(std::sqrt(drift2), DeformedError(level, mesh.copies, rest.cast<float>()));
}

}  // namespace

std::vector<MeshLevel> MakeLevels(const SeamedMesh& mesh, const Points& rest,
                                  double metres_per_uv) {
  std::vector<MeshLevel> levels;
  Simplifier simplifier(mesh, rest);
  levels.push_back(simplifier.Level());
  while (levels.size() < kMaxLevels) {
    const int before = simplifier.count();
    if (before / 2 < kMinLevelTriangles || !simplifier.Reduce(before / 2)) break;
    levels.push_back(simplifier.Level());
    levels.back().error = RestError(levels.back(), mesh, rest, metres_per_uv);
  }
  return levels;
}

double DeformedError(const MeshLevel& level, const std::vector<int>& copies,
                     const PointsF& vertices) {
  const auto count = static_cast<int>(vertices.rows());
  const auto of = [&](int drawn) {
    return drawn < count ? drawn : copies[static_cast<std::size_t>(drawn - count)];
  };
  float largest2 = 0;
  for (const MeshLevel::Place& place : level.dropped) {
    Eigen::RowVector3f way = vertices.row(of(place.vertex));
    for (int k = 0; k < 3; ++k) way -= place.weights[k] * vertices.row(of(place.corners[k]));
    largest2 = std::max(largest2, way.squaredNorm());
  }
  return std::max(level.error, std::sqrt(static_cast<double>(largest2)));
}

}  // namespace hpdm
