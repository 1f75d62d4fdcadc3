#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "engine/energy/metric_energy.h"

namespace hpdm {

/// The factorisation P A P^T = L L^T of a sparse matrix (approximate minimum degree ordering). The
/// two triangular solves are separate, so a step can add contacts between them. Rows "in factor
/// order" are those of P b. Constant once built; solves allocate nothing.
class SparseCholesky {
 public:
  /// `A`: n x n, symmetric positive definite. Throws InputError with `remedy` if it is not.
  SparseCholesky(const ScalarStiffness& A, const std::string& remedy);

  Eigen::Index size() const { return static_cast<Eigen::Index>(inverse_diagonal_.size()); }
  /// Returns the number of entries of L: multiplications of a triangular solve for each column.
  std::int64_t nonzeros() const { return static_cast<std::int64_t>(rows_.size()) + size(); }

  /// Returns the row of P b that is row i of b.
  int Place(Eigen::Index i) const { return place_[i]; }

  /// x <- L^-1 x, n x 3, in factor order.
  void SolveLower(Points* x) const;
  /// x <- L^-1 x for one column with few non-zero rows. Skips what stays zero, so the cost is the
  /// part of L between those rows and the root of the elimination tree.
  void SolveLowerSparse(Eigen::Ref<Eigen::VectorXd> x) const;
  /// x <- L^-T x, n x 3, in factor order.
  void SolveUpper(Points* x) const;
  /// x <- A^-1 x, n x 3, in the order of A. Allocates.
  void Solve(Eigen::Ref<Points> x) const;

 private:
  std::vector<int> place_;          // n
  std::vector<std::size_t> first_;  // n + 1: first entry of each column of L below the diagonal
  std::vector<int> rows_;           // ascending in each column
  std::vector<double> values_;
  std::vector<double> inverse_diagonal_;  // n
};

}  // namespace hpdm
