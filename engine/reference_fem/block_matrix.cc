#include "engine/reference_fem/block_matrix.h"

#include <algorithm>

#include "engine/base/check.h"

namespace hpdm {

BlockMatrix::BlockMatrix(const Tetrahedra& elements, int nodes) {
  std::vector<std::vector<int>> neighbours(static_cast<std::size_t>(nodes));
  for (Eigen::Index e = 0; e < elements.rows(); ++e) {
    for (Eigen::Index a = 0; a < elements.cols(); ++a) {
      std::vector<int>& row = neighbours[static_cast<std::size_t>(elements(e, a))];
      for (Eigen::Index b = 0; b < elements.cols(); ++b) row.push_back(elements(e, b));
    }
  }
  starts_.push_back(0);
  for (int n = 0; n < nodes; ++n) {
    std::vector<int>& row = neighbours[static_cast<std::size_t>(n)];
    row.push_back(n);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    columns_.insert(columns_.end(), row.begin(), row.end());
    starts_.push_back(static_cast<int>(columns_.size()));
    std::vector<int>().swap(row);
  }
  blocks_.assign(columns_.size(), Matrix3d::Zero());
}

Matrix3d& BlockMatrix::At(int row, int column) {
  const auto first = columns_.begin() + Start(row), last = columns_.begin() + Start(row + 1);
  const auto found = std::lower_bound(first, last, column);
  HPDM_CHECK(found != last && *found == column);
  return blocks_[static_cast<std::size_t>(found - columns_.begin())];
}

void BlockMatrix::SetZero() { std::fill(blocks_.begin(), blocks_.end(), Matrix3d::Zero()); }

void BlockMatrix::Add(const BlockMatrix& other) {
  HPDM_CHECK(blocks_.size() == other.blocks_.size());
  for (std::size_t b = 0; b < blocks_.size(); ++b) blocks_[b] += other.blocks_[b];
}

void BlockMatrix::Multiply(const Points& x, Points* y) const {
  y->resize(rows(), 3);
  for (int i = 0; i < rows(); ++i) {
    Vector3d sum = Vector3d::Zero();
    for (int e = Start(i); e < Start(i + 1); ++e) {
      sum.noalias() += Block(e) * x.row(Column(e)).transpose();
    }
    y->row(i) = sum.transpose();
  }
}

Eigen::SparseMatrix<double> LowerTriangle(const BlockMatrix& A) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < A.rows(); ++i) {
    for (int e = A.Start(i); e < A.Start(i + 1) && A.Column(e) <= i; ++e) {
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          const int row = 3 * i + r, column = 3 * A.Column(e) + c;
          if (row >= column) entries.emplace_back(row, column, A.Block(e)(r, c));
        }
      }
    }
  }
  Eigen::SparseMatrix<double> lower(3 * A.rows(), 3 * A.rows());
  lower.setFromTriplets(entries.begin(), entries.end());
  return lower;
}

}  // namespace hpdm
