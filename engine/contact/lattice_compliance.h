#pragma once

#include <span>

#include "engine/base/types.h"

namespace hpdm {

/// The non-zero entries of a lattice row b: control points and their weights.
struct SparseRow {
  std::span<const int> control_points;
  std::span<const double> weights;

  /// Returns the entries of control points below `n`; they ascend.
  SparseRow Head(int n) const {
    std::size_t count = 0;
    while (count < control_points.size() && control_points[count] < n) ++count;
    return {control_points.first(count), weights.first(count)};
  }
};

/// Fills `loads` (3n x 3) with a unit force along each axis on the point of row b. Row 3 a + d is
/// the load on control point a along d.
inline void FillUnitLoads(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> loads) {
  loads.setZero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    for (int d = 0; d < 3; ++d) loads(3 * b.control_points[i] + d, d) += b.weights[i];
  }
}

/// Returns b K^-1 b^T (m/N) from K^-1 (3n x 3n).
Matrix3d PointBlock(const Eigen::MatrixXd& inverse, const SparseRow& b);

/// The response dU = K^-1 dR of a lattice of n control points to small loads. With local functions,
/// their slots follow the control points.
class LatticeCompliance {
 public:
  virtual ~LatticeCompliance() = default;

  /// Computes K^-1 b^T about the last solution. `response` (3n x 3) gets the displacements under a
  /// unit force along each axis on the point of row b. Row 3 a + d is control point a along d.
  /// Deformation thread; allocates nothing.
  virtual void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const = 0;
  /// Computes the same for a set of rows at once, which can be cheaper: columns 3 i to 3 i + 2 of
  /// `responses` are those of row i.
  virtual void RespondToSet(std::span<const SparseRow> rows,
                            Eigen::Ref<Eigen::MatrixXd> responses) const {
    Eigen::Index column = 0;
    for (const SparseRow& b : rows) {
      RespondTo(b, responses.middleCols<3>(column));
      column += 3;
    }
  }

  /// Computes the first of two parts of the responses of a set of rows. The second part is added by
  /// AddOtherPart(), which is cheaper for a combination of the rows than for each. Here the first part
  /// is the whole response.
  virtual void RespondInPart(std::span<const SparseRow> rows,
                             Eigen::Ref<Eigen::MatrixXd> responses) const {
    RespondToSet(rows, responses);
  }
  /// Adds the second part to B K^-1 B^T of the set (`compliance`, 3 rows x 3 rows).
  virtual void AddOtherPart(Eigen::Ref<Eigen::MatrixXd> /*compliance*/) const {}
  /// Adds the second part to `responses` (3n x columns), those to the forces of the set's rows in
  /// each column of `forces` (3 rows x columns, N).
  virtual void AddOtherPart(const Eigen::Ref<const Eigen::MatrixXd>& /*forces*/,
                            Eigen::Ref<Eigen::MatrixXd> /*responses*/) const {}

  /// Replaces R by K^-1 R about the last solution: columns of 3n loads (N); row 3 a + d is control
  /// point a along d.
  virtual void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const = 0;

  /// Adds Y V (schur_complement.h), the part of local functions with the displacements `V` (3 slots,
  /// m), to `U_bar` (3n, m).
  virtual void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& /*V*/,
                            Eigen::Ref<Eigen::VectorXd> /*U_bar*/) const {}

  /// Returns b K^-1 b^T (m/N) at rest and without local functions; used for many rows at set-up.
  virtual Matrix3d PointCompliance(const SparseRow& b) const = 0;
};

}  // namespace hpdm
