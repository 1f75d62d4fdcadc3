#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "engine/base/types.h"

namespace hpdm {

/// A symmetric matrix of 3 x 3 blocks in which block i couples with blocks i - 2 to i + 2 only, and its
/// Cholesky factor. Sized once; afterwards it allocates nothing.
class BlockBand {
 public:
  static constexpr std::size_t kBeside = 2;

  /// `blocks`: the largest number of them.
  explicit BlockBand(std::size_t blocks = 0) : columns_(blocks + kBeside) {}

  /// Sets the first `blocks` columns to zero; they are the matrix from then on.
  void SetZero(std::size_t blocks) {
    size_ = blocks;
    for (std::size_t j = 0; j < size_; ++j) columns_[j].fill(Matrix3d::Zero());
  }
  std::size_t size() const { return size_; }
  /// Block (i, j) of the lower triangle, i - 2 <= j <= i.
  Matrix3d& At(std::size_t i, std::size_t j) { return columns_[j][i - j]; }
  const Matrix3d& At(std::size_t i, std::size_t j) const { return columns_[j][i - j]; }

  /// Replaces the matrix by its factor L, A = L L^T. False if it is not positive definite: then it is
  /// neither.
  bool Factor() {
    for (std::size_t j = 0; j < size_; ++j) {
      std::array<Matrix3d, kBeside + 1>& column = columns_[j];
      if (!FactorBlock(&column[0])) return false;
      const std::size_t below = std::min(kBeside, size_ - 1 - j);
      for (std::size_t d = 1; d <= below; ++d) SolveRight(column[0], &column[d]);
      for (std::size_t d = 1; d <= below; ++d) {
        for (std::size_t k = 1; k <= d; ++k) {
          columns_[j + k][d - k].noalias() -= column[d] * column[k].transpose();
        }
      }
    }
    return true;
  }

  /// Replaces b by L^-1 b. `Block`: a matrix of three rows.
  template <typename Block>
  void SolveForward(std::vector<Block>* b) const {
    for (std::size_t j = 0; j < size_; ++j) {
      Block& x = (*b)[j];
      const Matrix3d& L = columns_[j][0];
      x.row(0) /= L(0, 0);
      x.row(1) = (x.row(1) - L(1, 0) * x.row(0)) / L(1, 1);
      x.row(2) = (x.row(2) - L(2, 0) * x.row(0) - L(2, 1) * x.row(1)) / L(2, 2);
      for (std::size_t d = 1; d <= kBeside && j + d < size_; ++d) {
        (*b)[j + d].noalias() -= columns_[j][d] * x;
      }
    }
  }
  /// Replaces b by L^-T b.
  template <typename Block>
  void SolveBackward(std::vector<Block>* b) const {
    for (std::size_t j = size_; j-- > 0;) {
      Block& x = (*b)[j];
      for (std::size_t d = 1; d <= kBeside && j + d < size_; ++d) {
        x.noalias() -= columns_[j][d].transpose() * (*b)[j + d];
      }
      const Matrix3d& L = columns_[j][0];
      x.row(2) /= L(2, 2);
      x.row(1) = (x.row(1) - L(2, 1) * x.row(2)) / L(1, 1);
      x.row(0) = (x.row(0) - L(1, 0) * x.row(1) - L(2, 0) * x.row(2)) / L(0, 0);
    }
  }

 private:
  // A pivot below this share of its block's largest entry counts as zero.
  static constexpr double kLeastPivot = 1e-13;

  static bool FactorBlock(Matrix3d* a) {
    const double least = kLeastPivot * a->diagonal().cwiseAbs().maxCoeff();
    for (int k = 0; k < 3; ++k) {
      double pivot = (*a)(k, k);
      for (int m = 0; m < k; ++m) pivot -= (*a)(k, m) * (*a)(k, m);
      if (!(pivot > least)) return false;
      (*a)(k, k) = std::sqrt(pivot);
      for (int i = k + 1; i < 3; ++i) {
        double sum = (*a)(i, k);
        for (int m = 0; m < k; ++m) sum -= (*a)(i, m) * (*a)(k, m);
        (*a)(i, k) = sum / (*a)(k, k);
      }
    }
    return true;
  }
  // Replaces B by B L^-T.
  static void SolveRight(const Matrix3d& L, Matrix3d* B) {
    B->col(0) /= L(0, 0);
    B->col(1) = (B->col(1) - L(1, 0) * B->col(0)) / L(1, 1);
    B->col(2) = (B->col(2) - L(2, 0) * B->col(0) - L(2, 1) * B->col(1)) / L(2, 2);
  }

  std::vector<std::array<Matrix3d, kBeside + 1>> columns_;  // lower part of each column
  std::size_t size_ = 0;
};

}  // namespace hpdm
