#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/energy/metric_energy.h"

namespace hpdm {

/// P A P^T = L L^T of a sparse matrix, factorised once (approximate minimum degree ordering), with
/// the two triangular solves apart, so that a step can add contacts between them. Rows "in factor
/// order" are those of P b. Constant once built; solves allocate nothing.
class SparseCholesky {
 public:
  /// `A`: n x n, symmetric positive definite. Throws InputError with `remedy` when it is not.
  SparseCholesky(const ScalarStiffness& A, const std::string& remedy);

  Eigen::Index size() const { return static_cast<Eigen::Index>(inverse_diagonal_.size()); }
  /// Numbers in L, which a triangular solve multiplies once a column of the right-hand side.
  std::int64_t nonzeros() const { return static_cast<std::int64_t>(rows_.size()) + size(); }

  /// Where row i of b lies in P b.
  int Place(Eigen::Index i) const { return place_[i]; }

  /// x <- L^-1 x, n x 3, in factor order.
  void SolveLower(Points* x) const;
  /// x <- L^-1 x for one column that is zero but for a few rows: skips what stays zero, so that the
  /// cost is the part of L on the way from those rows to the root of the elimination tree.
  void SolveLowerSparse(Eigen::Ref<Eigen::VectorXd> x) const;
  /// x <- L^-T x, n x 3, in factor order.
  void SolveUpper(Points* x) const;
  /// x <- A^-1 x, n x 3, in the order of A. Allocates.
  void Solve(Eigen::Ref<Points> x) const;

 private:
  std::vector<int> place_;          // n
  std::vector<std::size_t> first_;  // n + 1: where each column of L below the diagonal begins
  std::vector<int> rows_;           // ascending in a column
  std::vector<double> values_;
  std::vector<double> inverse_diagonal_;  // n
};

}  // namespace hpdm
