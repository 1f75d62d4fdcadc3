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
/// 4. Blocks of cells, for contacts over a large area: centres of cells at least 2 `size` apart, and
///    with each the cells that it is nearest to.
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
  int cells() const { return static_cast<int>(block_of_.size()); }
  int blocks() const { return blocks_; }
  int BlockOf(int cell) const { return block_of_[cell]; }
  /// Number of samples of the largest block; a sample counts once for each of its cells.
  int most_samples() const { return most_samples_; }

 private:
  void FindBlocks(const std::vector<int>& centres, const std::vector<Vector3d>& points,
                  const std::vector<Vector3d>& normals, double size);

  std::vector<SurfaceSample> samples_;
  std::vector<int> first_sample_;  // F + 1
  std::vector<int> first_share_;   // samples + 1
  std::vector<Share> shares_;
  std::vector<int> block_of_;  // of each cell
  int blocks_ = 0;
  int most_samples_ = 0;
};

}  // namespace hpdm
