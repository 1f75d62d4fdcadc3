#pragma once

#include <span>
#include <utility>
#include <vector>

#include "engine/contact/surface_kernel.h"
#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A surface at rest as area samples, clustered into cells: the places at which contacts with
/// another organ are gathered. Constant once built; any thread may read it.
///
/// 1. Samples are the centroids of the triangles' parts with sides of at most kLongestSide, so they
///    lie about 2 mm apart on any mesh.
/// 2. Cell centres are samples, at least `size` (m) apart or facing more than 60 degrees apart.
///    Taken in the order of the samples, so a cell's number stays with its place.
/// 3. Each sample belongs to the cell with the nearest centre. Across the border between two cells
///    its share passes over from one to the other within an eighth of `size` on each side. A
///    sample's shares sum to one.
class ContactCells {
 public:
  static constexpr double kLongestSide = 0.003;  ///< m.

  ContactCells(const SurfaceMesh& rest, double size);

  int samples() const { return static_cast<int>(samples_.size()); }
  /// `weight` is the share of the triangle's area.
  const SurfaceSample& sample(int i) const { return samples_[i]; }
  /// Returns the range of a triangle's samples: [first, second).
  std::pair<int, int> OfTriangle(int triangle) const {
    return {first_sample_[triangle], first_sample_[triangle + 1]};
  }

  struct Share {
    int cell = 0;
    double share = 0;
  };
  std::span<const Share> CellsOf(int sample) const {
    return {shares_.data() + first_share_[sample],
            ToSize(first_share_[sample + 1] - first_share_[sample])};
  }
  int cells() const { return cells_; }
  /// Number of samples of the largest cell.
  int most_samples() const { return most_samples_; }

 private:
  std::vector<SurfaceSample> samples_;
  std::vector<int> first_sample_;  // F + 1
  std::vector<int> first_share_;   // samples + 1
  std::vector<Share> shares_;
  int cells_ = 0;
  int most_samples_ = 0;
};

}  // namespace hpdm
