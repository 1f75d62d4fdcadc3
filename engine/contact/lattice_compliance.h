#pragma once

#include <span>

#include "engine/base/types.h"

namespace hpdm {

/// A lattice row b by its entries that are not zero: control points and their weights.
struct SparseRow {
  std::span<const int> control_points;
  std::span<const double> weights;
};

/// `loads` (3n x 3): a unit force along each axis on the point of row b, that on control point a
/// along d in row 3 a + d.
inline void FillUnitLoads(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> loads) {
  loads.setZero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    for (int d = 0; d < 3; ++d) loads(3 * b.control_points[i] + d, d) += b.weights[i];
  }
}

/// b K^-1 b^T from K^-1 (3n x 3n).
Matrix3d PointBlock(const Eigen::MatrixXd& inverse, const SparseRow& b);

/// What a lattice of n control points (with local functions: their slots follow) answers to small
/// loads: dU = K^-1 dR.
class LatticeCompliance {
 public:
  virtual ~LatticeCompliance() = default;

  /// K^-1 b^T about the last solution: `response` (3n x 3) gets the displacements by a unit force
  /// along each axis on the point of row b, control point a along d in row 3 a + d. Deformation
  /// thread; allocates nothing.
  virtual void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const = 0;

  /// b K^-1 b^T (m/N) at rest and without local functions. At set-up, where the rows are many.
  virtual Matrix3d PointCompliance(const SparseRow& b) const = 0;
};

}  // namespace hpdm
