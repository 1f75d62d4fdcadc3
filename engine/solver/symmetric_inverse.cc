#include "engine/solver/symmetric_inverse.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/base/add_product.h"

namespace hpdm {
namespace {

// Pivots of a block: enough that arithmetic, not memory, limits the update of that rank.
constexpr Eigen::Index kPivots = 48;

// Returns the 1-norm of the symmetric matrix whose lower triangle is given.
double SymmetricNorm(const Eigen::MatrixXd& lower) {
  const Eigen::Index size = lower.rows();
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(size);
  for (Eigen::Index j = 0; j < size; ++j) {
    const auto below = lower.col(j).tail(size - j - 1).cwiseAbs();
    sums.tail(size - j - 1) += below;
    sums[j] += below.sum() + std::abs(lower(j, j));
  }
  return size > 0 ? sums.maxCoeff() : 0;
}

}  // namespace

double InvertSymmetric(Eigen::MatrixXd* A) {
  const Eigen::Index size = A->rows();
  const double norm = SymmetricNorm(*A);
  Eigen::MatrixXd columns(size, kPivots), scaled(size, kPivots);
  for (Eigen::Index first = 0; first < size; first += kPivots) {
    const Eigen::Index pivots = std::min(kPivots, size - first), end = first + pivots;
    const Eigen::LLT<Eigen::MatrixXd> factor(A->block(first, first, pivots, pivots));
    if (factor.info() != Eigen::Success) return 0;
    const Eigen::MatrixXd inverse = factor.solve(Eigen::MatrixXd::Identity(pivots, pivots));

    // The pivots' columns of the symmetric matrix, without the pivots' own rows.
    auto V = columns.leftCols(pivots);
    V.topRows(first) = A->block(first, 0, pivots, first).transpose();
    V.middleRows(first, pivots).setZero();
    V.bottomRows(size - end) = A->block(end, first, size - end, pivots);
    auto W = scaled.leftCols(pivots);
    W.noalias() = V * inverse;
    AddProductToLower(-1, W, V, *A);

    A->block(first, 0, pivots, first) = W.topRows(first).transpose();
    A->block(first, first, pivots, pivots) = -inverse;
    A->block(end, first, size - end, pivots) = W.bottomRows(size - end);
  }
  // After the sweep of all pivots, A is minus its inverse.
  for (Eigen::Index j = 0; j < size; ++j) {
    A->col(j).tail(size - j) *= -1;
    A->row(j).tail(size - j - 1) = A->col(j).tail(size - j - 1).transpose();
  }
  const double rcond = 1 / (norm * SymmetricNorm(*A));
  return rcond > 0 ? rcond : 0;  // 0 also for a NaN
}

}  // namespace hpdm
