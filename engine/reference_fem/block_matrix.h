#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "engine/reference_fem/tetra_mesh.h"

namespace hpdm {

/// A symmetric sparse matrix of 3 x 3 blocks, one for every two nodes that share an element, both
/// triangles stored, rows sorted. Acts on N x 3 vectors.
class BlockMatrix {
 public:
  BlockMatrix() = default;
  /// All blocks zero.
  BlockMatrix(const Tetrahedra& elements, int nodes);

  int rows() const { return static_cast<int>(starts_.size()) - 1; }
  int Start(int row) const { return starts_[static_cast<std::size_t>(row)]; }
  int Column(int entry) const { return columns_[static_cast<std::size_t>(entry)]; }
  const Matrix3d& Block(int entry) const { return blocks_[static_cast<std::size_t>(entry)]; }

  /// Returns the block of two nodes that share an element.
  Matrix3d& At(int row, int column);
  void SetZero();
  /// Adds a matrix over the same elements.
  void Add(const BlockMatrix& other);
  /// y = A x; y is resized.
  void Multiply(const Points& x, Points* y) const;

 private:
  std::vector<int> starts_;   // rows + 1
  std::vector<int> columns_;  // of each block
  std::vector<Matrix3d> blocks_;
};

/// The sum of a . b over the nodes.
inline double Dot(const Points& a, const Points& b) { return a.cwiseProduct(b).sum(); }

/// Returns the lower triangle as scalars; row 3 n + i is component i of node n.
Eigen::SparseMatrix<double> LowerTriangle(const BlockMatrix& A);

}  // namespace hpdm
