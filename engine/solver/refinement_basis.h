#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "engine/energy/strain_energy.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The finer splines that an organ can add where it is touched: hierarchical refinement (Forsey,
/// Bartels 1988) over `refinement` times as many cells, of which only a few near the contacts are
/// in use at a time (active_refinement.h). The basis has all of them that have tissue and none in a
/// support's region.
///
/// With control displacements U (n) and those of the local functions in use, V (m), the energy is
///
///     1/2 [U V] [K  K_c; K_c^T  K_loc] [U V]^T,
///
/// K as without them. K_c and K_loc are the elastic blocks of strain_energy.h, in which what is
/// projected of the dilatation of a local function couples to U only: its own volume is kept point
/// by point, so the sum stays convex. All that a set of functions needs is here, so a change of the
/// set costs a small dense factorisation and none of K (compliance_solver.h): Y = K^-1 K_c and the
/// reduced stiffness, the Schur complement Sigma = K_loc - K_c^T Y.
///
/// Constant once built; read by any thread.
class RefinementBasis {
 public:
  /// `K` (3n x 3n): of `lattice` over `tissue` by StrainStiffness with `dilatation`, with supports
  /// in `regions`. `tissue` must resolve the finer cells. Throws InputError when K is not positive
  /// definite, or when the coupling of the functions to the lattice takes too much memory.
  RefinementBasis(const Lattice& lattice, const LocalFunctionOptions& options,
                  const Quadrature& tissue, const MaterialOptions& material, Dilatation dilatation,
                  const std::vector<Quadrature>& regions, const FullStiffness& K);

  /// Functions, N, and control points of the lattice, n.
  int size() const { return finer_.size(); }
  int control_points() const { return static_cast<int>(inverse_.rows()) / 3; }
  const Lattice& finer() const { return finer_; }
  /// N x 3, m, world, rest: where each acts most.
  const Points& centres() const { return centres_; }

  /// K^-1 (3n x 3n, m/N).
  const Eigen::MatrixXd& inverse() const { return inverse_; }
  /// The columns 3 a .. 3 a + 2 of Y (3n x 3).
  auto Coupling(int a) const { return coupling_.block(0, 3 * a, inverse_.rows(), 3); }
  /// Memory of the largest arrays.
  double Bytes() const {
    return 8.0 * static_cast<double>(inverse_.size() + coupling_.size()) +
           12.0 * static_cast<double>(sparse_.nonZeros() + own_.nonZeros());
  }
  /// Sigma_ab (3 x 3, N/m), without allocation.
  Matrix3d ReducedStiffness(int a, int b) const;

 private:
  Lattice finer_;
  Points centres_;
  Eigen::MatrixXd inverse_;
  // A function couples to U directly and through the projected dilatation p: K_c = c + H^T d
  // with few entries in c (3n x 3N) and d (m x 3N). `sparse_` is [c; d]; `coupling_` is Z [c; d]
  // with Z = [I H^T]^T K^-1 [I H^T], its first 3n rows Y.
  Eigen::SparseMatrix<double> sparse_;
  Eigen::MatrixXd coupling_;
  Eigen::SparseMatrix<double> own_;  // 3N x 3N: K_loc
};

}  // namespace hpdm
