#pragma once

#include <Eigen/Core>

#include "engine/base/vector_width.h"

namespace hpdm {

/// Eight columns, stored row by row: one vector of the widest processors for each row.
using FewColumns = Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::RowMajor>;
constexpr int kFewColumns = FewColumns::ColsAtCompileTime;
/// Returns the columns of the full groups of kFewColumns that hold `columns`.
constexpr Eigen::Index FullGroups(Eigen::Index columns) {
  return (columns + kFewColumns - 1) / kFewColumns * kFewColumns;
}
using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Products and solutions with dense matrices for a few columns at once, so that a large matrix passes
/// through the processor once for all of them. They use the processor's widest vectors; each entry is
/// summed in the same order, without fused operations, whatever their width: results are equal bit for
/// bit. Any thread; they allocate nothing. `width`: another than the widest, for tests.

/// Replaces the lower triangle of A by its Cholesky factor L, A = L L^T, and leaves the upper one. False
/// if A is not positive definite; A is then lost. `done`: the first columns that are L's already, in
/// all rows; the result is the same bit for bit as from the start.
bool FactorLower(Eigen::Ref<Eigen::MatrixXd> A, Eigen::Index done = 0,
                 VectorWidth width = WidestVectors());

/// Replaces X (n x 8) by L^-1 X, or by L^-T X. Reads the lower triangle of L (n x n) alone.
void SolveLower(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<FewColumns> X,
                VectorWidth width = WidestVectors());
void SolveLowerTransposed(const Eigen::Ref<const Eigen::MatrixXd>& L, Eigen::Ref<FewColumns> X,
                          VectorWidth width = WidestVectors());

/// Sets Y = A X, with A of m x k, X of k x 8, Y of m x 8.
void Multiply(const Eigen::Ref<const RowMajorMatrix>& A, const Eigen::Ref<const FewColumns>& X,
              Eigen::Ref<FewColumns> Y, VectorWidth width = WidestVectors());
/// Adds A X to Y.
void MultiplyAndAdd(const Eigen::Ref<const RowMajorMatrix>& A,
                    const Eigen::Ref<const FewColumns>& X, Eigen::Ref<FewColumns> Y,
                    VectorWidth width = WidestVectors());

}  // namespace hpdm
