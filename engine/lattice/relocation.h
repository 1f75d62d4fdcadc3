#pragma once

#include <cstddef>
#include <vector>

#include "engine/base/types.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Stage C of a step (Eq. 4): x = X + B U with constant weights B (V x n).
///
/// 1. A plain sparse product reads an index and a weight for every entry of B. Vertices in one cell
///    of a lattice share their control points. So the vertices are sorted by the columns of their
///    rows and taken eight at a time.
/// 2. A block stores its columns once and its weights as one dense 8 x c panel. A column of the
///    panel is one or two vector loads.
/// 3. A block that straddles two cells has the columns of both, with zeros.
/// 4. Each vertex is summed by itself, in the order of its columns. So the result has the bits of
///    the plain product at any vector width.
///
/// Constant once built; read by any thread; the products allocate nothing.
class Relocation {
 public:
  static constexpr int kLanes = 8;

  /// `rest`: X, V x 3, m; `weights`: B, V x n.
  Relocation(const Points& rest, const WeightMatrix& weights);

  /// Computes x = X + B U. `U`: n x 3, m, finite; further rows are ignored. `x`: V x 3, m, already
  /// of that size.
  void Relocate(const Points& U, Points* x) const;
  /// Computes u = B U, the same without X.
  void Displace(const Points& U, Points* u) const;

  /// Does Relocate() with baseline instructions: the reference for tests of the faster ones.
  void RelocatePlainly(const Points& U, Points* x) const;

 private:
  struct Block {
    std::size_t first_column = 0;  ///< Index into columns_; the weights begin at kLanes times that.
    int columns = 0;
    int vertices = 0;  ///< kLanes, except in the last block.
  };
  using SumBlock = void (*)(const double* weights, const int* columns, int count, const double* U,
                            double (&sum)[3][kLanes]);
  void Multiply(SumBlock sum_block, const Points& U, bool from_rest, Points* x) const;

  Eigen::Index control_points_;
  std::vector<Block> blocks_;
  std::vector<int> columns_;     // block after block, ascending in each
  std::vector<double> weights_;  // kLanes for each column
  std::vector<int> vertices_;    // V: the vertex of each lane
  Points rest_;                  // V x 3, m, in the order of the lanes
  SumBlock sum_block_;           // the fastest one of this machine
};

}  // namespace hpdm
