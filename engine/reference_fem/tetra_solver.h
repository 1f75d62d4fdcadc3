#pragma once

#include <Eigen/SparseCholesky>
#include <vector>

#include "engine/reference_fem/block_matrix.h"

namespace hpdm {

/// Solves K x = b for the stiffness matrix of a tetrahedral mesh. Linear elements: Cholesky.
/// Quadratic elements: conjugate gradients, preconditioned by one multigrid cycle of two levels.
/// The fine level is forward and backward block Gauss-Seidel on all nodes, the coarse one Cholesky
/// on the linear elements of the corners. The number of iterations hardly grows with the mesh.
class TetraSolver {
 public:
  explicit TetraSolver(const TetraMesh& mesh);

  /// Prepares for K, which is kept by reference until the next call. The factor of an earlier K
  /// that is close enough stays the preconditioner while iterations remain few. Returns false if K
  /// is not positive definite on the corners' elements.
  bool Factorise(const BlockMatrix& K);

  /// Improves x until |b - K x| <= tolerance |b|; both N x 3. Returns false if K is not positive
  /// definite or the iterations run out.
  bool Solve(const Points& b, double tolerance, Points* x);

  int iterations() const { return iterations_; }  ///< Sum over all solves so far.

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
  bool fresh_ = false;        // the factor belongs to the present K
  int fresh_iterations_ = 0;  // in the first solve after the factorisation; 0 before it
  int last_iterations_ = 0;
  int iterations_ = 0;
};

}  // namespace hpdm
