#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/types.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Stage C of a step (Eq. 4): x = X + B U, for weights B (V x n) that stay.
///
/// A plain sparse product reads an index and a weight for every entry of B. Vertices in one cell of
/// a lattice share their control points, so here the vertices are sorted by the columns of their
/// rows and taken eight at a time: a block stores its columns once and its weights as one dense
/// 8 x c panel, of which a column is one or two vector loads. Blocks that straddle two cells hold
/// the columns of both, with zeros. Each vertex is still summed by itself, in the order of its
/// columns, so the result has the same bits at any vector width, and those of the plain product.
///
/// Constant once built; read by any thread; the products allocate nothing.
class Relocation {
 public:
  static constexpr int kLanes = 8;

  /// `rest`: X, V x 3, m; `weights`: B, V x n.
  Relocation(const Points& rest, const WeightMatrix& weights);

  /// x = X + B U. `U`: n x 3, m, finite (further rows are not read); `x`: V x 3, m, already of that
  /// size.
  void Relocate(const Points& U, Points* x) const;
  /// u = B U, the same without X.
  void Displace(const Points& U, Points* u) const;

  /// Relocate() with the machine's baseline instructions: what the faster ones are tested against.
  void RelocatePlainly(const Points& U, Points* x) const;

 private:
  struct Block {
    std::size_t first_column = 0;  ///< Of columns_; its weights begin at kLanes times that.
    int columns = 0;
    int vertices = 0;  ///< kLanes, but for the last block.
  };
  using SumBlock = void (*)(const double* weights, const int* columns, int count, const double* U,
                            double (&sum)[3][kLanes]);
  void Multiply(SumBlock sum_block, const Points& U, bool from_rest, Points* x) const;

  Eigen::Index control_points_;
  std::vector<Block> blocks_;
  std::vector<int> columns_;     // of each block, ascending
  std::vector<double> weights_;  // kLanes a column
  std::vector<int> vertices_;    // V: which vertex each lane is
  Points rest_;                  // V x 3, m, in the order of the lanes
  SumBlock sum_block_;           // the fastest of this machine
};

}  // namespace hpdm
