#include "engine/pairs/contact_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

namespace hpdm {
namespace {

constexpr double kFacing = 0.5;       // least cosine within a cell
constexpr double kLeastShare = 0.05;  // smaller shares are dropped

// Points in buckets of a given size. Found in the order in which they were added.
class Buckets {
 public:
  explicit Buckets(double size) : size_(size) {}
  void Add(const Vector3d& p, int value) { buckets_[Key(p)].push_back(value); }
  template <typename Visit>
  void ForEachAround(const Vector3d& p, const Visit& visit) const {
    const std::array<int, 3> key = Key(p);
    for (int i = 0; i < 27; ++i) {
      const auto found =
          buckets_.find({key[0] + i % 3 - 1, key[1] + i / 3 % 3 - 1, key[2] + i / 9 - 1});
      if (found == buckets_.end()) continue;
      for (const int value : found->second) visit(value);
    }
  }

 private:
  std::array<int, 3> Key(const Vector3d& p) const {
    std::array<int, 3> key;
    for (int d = 0; d < 3; ++d) key[d] = static_cast<int>(std::floor(p[d] / size_));
    return key;
  }
  double size_;
  std::map<std::array<int, 3>, std::vector<int>> buckets_;
};

// Returns those of `candidates` that are centres: at least `size` apart or facing apart. Adds them to
// `buckets`.
std::vector<int> FindCentres(const std::vector<int>& candidates,
                             const std::vector<Vector3d>& points,
                             const std::vector<Vector3d>& normals, double size, Buckets* buckets) {
  std::vector<int> centres;
  for (const int i : candidates) {
    bool covered = false;
    buckets->ForEachAround(points[i], [&](int cell) {
      covered = covered || ((points[centres[cell]] - points[i]).norm() < size &&
                            normals[centres[cell]].dot(normals[i]) > kFacing);
    });
    if (covered) continue;
    buckets->Add(points[i], static_cast<int>(centres.size()));
    centres.push_back(i);
  }
  return centres;
}

}  // namespace

void ContactCells::FindBlocks(const std::vector<int>& centres, const std::vector<Vector3d>& points,
                              const std::vector<Vector3d>& normals, double size) {
  Buckets buckets(size);
  const std::vector<int> middles = FindCentres(centres, points, normals, size, &buckets);
  blocks_ = static_cast<int>(middles.size());
  for (const int centre : centres) {
    int nearest = 0;
    double nearest2 = std::numeric_limits<double>::infinity();
    buckets.ForEachAround(points[centre], [&](int block) {
      if (normals[middles[block]].dot(normals[centre]) <= kFacing) return;
      const double distance2 = (points[middles[block]] - points[centre]).squaredNorm();
      if (distance2 >= nearest2) return;
      nearest2 = distance2;
      nearest = block;
    });
    block_of_.push_back(nearest);
  }
}

ContactCells::ContactCells(const SurfaceMesh& rest, double size)
    : samples_(SurfaceInRegion(rest, std::nullopt, {}, kLongestSide)) {
  std::vector<Vector3d> points, normals;
  first_sample_.assign(ToSize(rest.triangles.rows()) + 1, 0);
  for (SurfaceSample& sample : samples_) {
    points.push_back(AtSample(sample, rest.triangles, rest.vertices));
    const Vector3d normal = TwiceAreaNormal(rest.vertices, rest.triangles, sample.triangle);
    sample.weight /= normal.norm() / 2;
    normals.push_back(normal.normalized());
    ++first_sample_[ToSize(sample.triangle) + 1];
  }
  for (std::size_t t = 1; t < first_sample_.size(); ++t) first_sample_[t] += first_sample_[t - 1];

  std::vector<int> all(samples_.size());
  std::iota(all.begin(), all.end(), 0);
  Buckets buckets(size);
  const std::vector<int> centres = FindCentres(all, points, normals, size, &buckets);
  FindBlocks(centres, points, normals, 2 * size);

  // (d^2 - d_0^2) / (2 x the centres' distance) is the distance from the border of two cells.
  const double fade = 2 * size * (size / 8) / -std::log(kLeastShare);
  std::vector<int> counts(ToSize(blocks_), 0);
  std::vector<Share> around;
  first_share_.push_back(0);
  for (int i = 0; i < samples(); ++i) {
    around.clear();
    double nearest2 = std::numeric_limits<double>::infinity();
    buckets.ForEachAround(points[i], [&](int cell) {
      if (normals[centres[cell]].dot(normals[i]) <= kFacing) return;
      const double distance2 = (points[centres[cell]] - points[i]).squaredNorm();
      nearest2 = std::min(nearest2, distance2);
      around.push_back({cell, distance2});
    });
    double sum = 0;
    for (Share& share : around) {
      share.share = std::exp(-(share.share - nearest2) / fade);
      if (share.share < kLeastShare) share.share = 0;
      sum += share.share;
    }
    for (const Share& share : around) {
      if (share.share == 0) continue;
      shares_.push_back({share.cell, share.share / sum});
      most_samples_ = std::max(most_samples_, ++counts[ToSize(block_of_[share.cell])]);
    }
    first_share_.push_back(static_cast<int>(shares_.size()));
  }
}

}  // namespace hpdm
