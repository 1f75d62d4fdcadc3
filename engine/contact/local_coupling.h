#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Most contact rows of one jaw's footprint, and of the two jaws of a tool (footprint.h).
inline constexpr int kFootprintRows = 4;
inline constexpr int kGraspRows = 2 * kFootprintRows;

/// Local compliance of rows that are tied together: 3m x 3m, symmetric, m/N, in 3 x 3 blocks.
using LocalCoupling = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor,
                                    3 * kGraspRows, 3 * kGraspRows>;

/// The place of one contact row in a group of coupled rows. The diagonal block is also the row's
/// own local compliance.
struct CoupledRow {
  const LocalCoupling* coupling = nullptr;  ///< nullptr: the row is alone. Outlives the row.
  int place = 0;                            ///< Number of the row's block.

  /// Returns the displacement of this row for a unit force on another one, m/N.
  Matrix3d To(const CoupledRow& other) const {
    if (coupling == nullptr || coupling != other.coupling) return Matrix3d::Zero();
    return coupling->block<3, 3>(3 * place, 3 * other.place);
  }
};

}  // namespace hpdm
