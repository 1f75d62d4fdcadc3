#include "scenes/generator/shapes/vessel_tree.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "scenes/generator/shapes/solid_noise.h"

namespace hpdm {
namespace {

/// Widest spot of Coverage, m.
constexpr double kMaxVesselSpot = 1e-3;

/// Newton's method from above; the C library's cbrt differs between machines in the last bit.
double CubeRoot(double x) {
  double root = std::max(x, 1.0);
  for (int i = 0; i < 40; ++i) root -= (root - x / (root * root)) / 3;
  return root;
}

/// Returns points of a shape's surface, evenly scattered except in strongly curved parts.
std::vector<Vector3d> Scatter(const ImplicitShape& shape, int count, std::uint64_t seed) {
  RandomNumbers random(seed);
  const Bounds box = shape.bounds();
  std::vector<Vector3d> points;
  while (static_cast<int>(points.size()) < count) {
    Vector3d p;
    for (int d = 0; d < 3; ++d) p[d] = box.min[d] + random.Fraction() * (box.max[d] - box.min[d]);
    // Samples a shell only, so that points deep inside do not crowd where the field is flat.
    if (std::abs(shape.Sample(p).value) > 0.004) continue;
    points.push_back(ProjectToLevel(shape, p, 0));
  }
  return points;
}

}  // namespace

VesselTree::VesselTree(const ImplicitShape& shape, const std::vector<std::vector<Vector3d>>& trunks,
                       const VesselOptions& options) {
  for (const std::vector<Vector3d>& trunk : trunks) {
    int parent = -1;
    Vector3d from = trunk.front();
    for (const Vector3d& to : trunk) {
      const int pieces = std::max(1, static_cast<int>((to - from).norm() / options.step));
      for (int i = parent < 0 ? pieces : 1; i <= pieces; ++i) {
        const Vector3d p = from + (to - from) * (static_cast<double>(i) / pieces);
        parent = AddNode(ProjectToLevel(shape, p, 0), parent);
      }
      from = to;
    }
  }
  Grow(shape, Scatter(shape, options.targets, options.seed), options);
  SetRadii(options.finest_radius);
  SortIntoCells(options.step);
}

int VesselTree::AddNode(const Vector3d& p, int parent) {
  nodes_.push_back({p, parent, 0});
  return static_cast<int>(nodes_.size()) - 1;
}

void VesselTree::Grow(const ImplicitShape& shape, std::vector<Vector3d> targets,
                      const VesselOptions& options) {
  std::vector<int> nearest(targets.size(), 0);
  std::vector<double> distance(targets.size(), std::numeric_limits<double>::max());
  std::size_t seen = 0;  // number of nodes that the targets have seen
  constexpr int kMaxRounds = 400;
  for (int round = 0; round < kMaxRounds; ++round) {
    for (; seen < nodes_.size(); ++seen) {
      for (std::size_t i = 0; i < targets.size(); ++i) {
        const double d = (targets[i] - nodes_[seen].p).norm();
        if (d >= distance[i]) continue;
        distance[i] = d;
        nearest[i] = static_cast<int>(seen);
      }
    }
    std::vector<Vector3d> pull(nodes_.size(), Vector3d::Zero());
    for (std::size_t i = 0; i < targets.size(); ++i) {
      if (distance[i] < options.reached || distance[i] > options.sight) continue;
      pull[ToSize(nearest[i])] += (targets[i] - nodes_[ToSize(nearest[i])].p) / distance[i];
    }
    for (std::size_t n = 0; n < pull.size(); ++n) {
      const double length = pull[n].norm();
      if (length < 1e-3) continue;
      const Vector3d from = nodes_[n].p;
      Vector3d to = ProjectToLevel(shape, from + pull[n] * (options.step / length), 0);
      // Targets on opposite sides can hold a node where it is.
      bool is_new = (to - from).norm() > 0.3 * options.step;
      for (std::size_t m = pull.size(); is_new && m < nodes_.size(); ++m) {
        is_new = (nodes_[m].p - to).norm() > 0.3 * options.step;
      }
      for (std::size_t m = 0; is_new && m < pull.size(); ++m) {
        is_new = nodes_[m].parent != static_cast<int>(n) ||
                 (nodes_[m].p - to).norm() > 0.3 * options.step;
      }
      if (is_new) AddNode(to, static_cast<int>(n));
    }
    if (seen == nodes_.size()) return;
  }
}

void VesselTree::SetRadii(double finest_radius) {
  std::vector<double> cubes(nodes_.size(), 0);
  for (std::size_t n = nodes_.size(); n-- > 0;) {
    if (cubes[n] == 0) cubes[n] = 1;
    if (nodes_[n].parent >= 0) cubes[ToSize(nodes_[n].parent)] += cubes[n];
    nodes_[n].radius = finest_radius * CubeRoot(cubes[n]);
  }
}

void VesselTree::SortIntoCells(double step) {
  Vector3d low = nodes_.front().p, high = low;
  double widest = 0;
  for (const Node& node : nodes_) {
    low = low.cwiseMin(node.p);
    high = high.cwiseMax(node.p);
    widest = std::max(widest, node.radius);
  }
  // A point near a segment is in one of the 27 cells around its end.
  cell_ = 2 * step + widest + kMaxVesselSpot;
  origin_ = low - Vector3d::Constant(2 * cell_);
  count_ = ((high - origin_) / cell_).cast<int>().array() + 3;
  cells_.resize(static_cast<std::size_t>(count_.prod()));
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const Eigen::Vector3i cell = ((nodes_[n].p - origin_) / cell_).cast<int>();
    cells_[Number(cell)].push_back(static_cast<int>(n));
  }
}

std::size_t VesselTree::Number(const Eigen::Vector3i& cell) const {
  return static_cast<std::size_t>((cell.z() * count_.y() + cell.y()) * count_.x() + cell.x());
}

double VesselTree::Coverage(const Vector3d& p, double spot) const {
  const Vector3d place = (p - origin_) / cell_;
  for (int d = 0; d < 3; ++d) {
    if (!(place[d] >= 1 && place[d] < count_[d] - 1)) return 0;
  }
  double coverage = 0;
  for (int i = 0; i < 27; ++i) {
    const Eigen::Vector3i offset(i % 3 - 1, (i / 3) % 3 - 1, i / 9 - 1);
    for (const int n : cells_[Number(place.cast<int>() + offset)]) {
      const Node& end = nodes_[ToSize(n)];
      const Node& start = end.parent < 0 ? end : nodes_[ToSize(end.parent)];
      const Vector3d along = end.p - start.p;
      const double length_squared = along.squaredNorm();
      const double t =
          length_squared > 0 ? std::clamp((p - start.p).dot(along) / length_squared, 0.0, 1.0) : 0;
      const double radius = start.radius + t * (end.radius - start.radius);
      const double distance = (p - start.p - t * along).norm();
      const double filled = std::min(1.0, radius / spot);
      coverage = std::max(coverage, filled * SmoothStep(radius + spot, radius - spot, distance));
    }
  }
  return coverage;
}

}  // namespace hpdm
