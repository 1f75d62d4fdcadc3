#pragma once

#include <Eigen/SparseCholesky>
#include <vector>

#include "engine/reference_fem/block_matrix.h"

namespace hpdm {

/// Solves K x = b for the stiffness matrix of a tetrahedral mesh: Cholesky for linear elements;
/// for quadratic ones conjugate gradients, preconditioned by one multigrid cycle of two levels
/// (forward and backward block Gauss-Seidel on all nodes, Cholesky on the linear elements of the
/// corners), so that the number of iterations hardly grows with the mesh.
class TetraSolver {
 public:
  explicit TetraSolver(const TetraMesh& mesh);

  /// Prepares for K, which is kept by reference until the next call. The factor of an earlier, near
  /// enough K is kept as preconditioner while it serves. False when K is not positive definite on
  /// the corners' elements.
  bool Factorise(const BlockMatrix& K);

  /// Adds to x until |b - K x| <= tolerance |b|; both N x 3. False when K turns out not to be
  /// positive definite, or when the iterations run out.
  bool Solve(const Points& b, double tolerance, Points* x);

  int iterations() const { return iterations_; }  ///< Of all solves so far.

 private:
  bool Refactor();
  bool TrySolve(const Points& b, double tolerance, Points* x);
  Points Precondition(const Points& residual) const;

  const TetraMesh& mesh_;
  const BlockMatrix* K_ = nullptr;
  BlockMatrix coarse_;
  std::vector<Matrix3d> inverse_diagonal_;
  Eigen::SimplicialLLT<Eigen::SparseMatrix<double>> factor_;
  bool analysed_ = false;
  bool fresh_ = false;        // the factor is of the present K
  int fresh_iterations_ = 0;  // of the first solve after the factorisation; 0 before it
  int last_iterations_ = 0;
  int iterations_ = 0;
};

}  // namespace hpdm
