#include "scenes/generator/meshing/mesh_decimation.h"

#include <algorithm>
#include <array>
#include <queue>
#include <string>
#include <tuple>
#include <vector>

#include "engine/base/error.h"
#include "engine/mesh/quadric.h"

namespace hpdm {
namespace {

/// An edge waiting to be merged; stale if a vertex's version has changed.
struct Candidate {
  double cost;  ///< m^4.
  int a, b;
  int version_a, version_b;
  Vector3d target;

  /// Orders by cost, then by index, so that the order does not depend on the queue's
  /// implementation.
  bool operator<(const Candidate& other) const {
    return std::tie(cost, a, b, version_a, version_b) >
           std::tie(other.cost, other.a, other.b, other.version_a, other.version_b);
  }
};

class Decimator {
 public:
  explicit Decimator(EditableMesh* mesh)
      : mesh_(*mesh), quadrics_(mesh->vertex_capacity()), versions_(mesh->vertex_capacity(), 0) {
    for (int t = 0; t < mesh_.triangle_capacity(); ++t) {
      if (!mesh_.IsTriangle(t)) continue;
      const Vector3d area_vector = mesh_.AreaVector(t);
      const double twice_area = area_vector.norm();
      if (!(twice_area > 0)) continue;
      for (const int v : mesh_.corners(t)) {
        quadrics_[v].AddPlane(area_vector / twice_area, mesh_.position(v), twice_area / 6);
      }
    }
    for (int v = 0; v < mesh_.vertex_capacity(); ++v) {
      if (!mesh_.IsVertex(v)) continue;
      for (const int w : mesh_.Neighbours(v)) {
        if (v < w) Push(v, w);
      }
    }
  }

  void Run(int triangle_count) {
    while (mesh_.triangle_count() > triangle_count) {
      if (queue_.empty()) {
        throw InputError("mesh decimation: " + std::to_string(triangle_count) +
                         " triangles cannot be reached without folding the surface; ask for more");
      }
      const Candidate next = queue_.top();
      queue_.pop();
      if (versions_[next.a] != next.version_a || versions_[next.b] != next.version_b) continue;
      if (!mesh_.CanCollapse(next.a, next.b) || !KeepsShape(next)) continue;
      Merge(next);
    }
  }

 private:
  void Push(int a, int b) {
    // Weight of the length in the cost: an edge in a flat region counts as if the surface deviated
    // from it by one hundredth of its length.
    constexpr double kLengthCost = 1e-4, kCentring = 1e-3;
    Quadric sum = quadrics_[a];
    sum += quadrics_[b];
    const Vector3d middle = 0.5 * (mesh_.position(a) + mesh_.position(b));
    const Vector3d target = sum.Minimiser(middle, kCentring);
    const double length_squared = (mesh_.position(a) - mesh_.position(b)).squaredNorm();
    const double cost =
        std::max(sum.Error(target), 0.0) + kLengthCost * sum.weight() * length_squared;
    queue_.push({cost, a, b, versions_[a], versions_[b], target});
  }

  bool KeepsShape(const Candidate& edge) const {
    constexpr double kSliver = 0.03;  // Sine squared of 10 degrees.
    double before_least = 1, after_least = 1;
    for (const int v : {edge.a, edge.b}) {
      for (const int t : mesh_.star(v)) {
        const std::array<int, 3>& c = mesh_.corners(t);
        std::array<Vector3d, 3> corner;
        int moved = 0;
        for (int k = 0; k < 3; ++k) {
          const bool moves = c[k] == edge.a || c[k] == edge.b;
          moved += moves;
          corner[k] = moves ? edge.target : mesh_.position(c[k]);
        }
        before_least = std::min(
            before_least,
            SmallestAngleMeasure(mesh_.position(c[0]), mesh_.position(c[1]), mesh_.position(c[2])));
        if (moved == 2) continue;
        const Vector3d before = mesh_.AreaVector(t);
        const Vector3d after = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        if (before.dot(after) <= 0.5 * before.norm() * after.norm()) return false;
        after_least = std::min(after_least, SmallestAngleMeasure(corner[0], corner[1], corner[2]));
      }
    }
    return after_least >= std::min(kSliver, before_least);
  }

  void Merge(const Candidate& edge) {
    mesh_.Collapse(edge.a, edge.b, edge.target);
    quadrics_[edge.a] += quadrics_[edge.b];
    ++versions_[edge.a];
    ++versions_[edge.b];
    for (const int w : mesh_.Neighbours(edge.a)) Push(std::min(edge.a, w), std::max(edge.a, w));
  }

  EditableMesh& mesh_;
  std::vector<Quadric> quadrics_;
  std::vector<int> versions_;
  std::priority_queue<Candidate> queue_;
};

}  // namespace

void Decimate(int triangle_count, EditableMesh* mesh) {
  if (triangle_count % 2 != 0 || triangle_count < 4 || triangle_count > mesh->triangle_count()) {
    throw InputError("mesh decimation: cannot make " + std::to_string(triangle_count) +
                     " triangles of " + std::to_string(mesh->triangle_count()) +
                     "; ask for an even number from 4 to that");
  }
  Decimator(mesh).Run(triangle_count);
}

}  // namespace hpdm
