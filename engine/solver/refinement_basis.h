#pragma once

#include <Eigen/SparseCore>
#include <vector>

#include "engine/energy/strain_energy.h"
#include "engine/lattice/active_refinement.h"
#include "engine/lattice/lattice.h"
#include "engine/tissue/fillings_and_layers.h"

namespace hpdm {

/// The finer splines (local functions) that an organ can add near its contacts: hierarchical
/// refinement (Forsey, Bartels 1988) over `refinement` times as many cells. Only a few are in use
/// at a time (active_refinement.h). The basis has the functions that have tissue, except in the
/// regions of supports.
///
/// With control displacements U (n) and displacements V (m) of the local functions in use, the
/// energy is
///     1/2 [U V] [K  K_c; K_c^T  K_loc] [U V]^T.
///
/// 1. K is the stiffness without local functions. K_c and K_loc are the elastic blocks of
///    strain_energy.h.
/// 2. The projected dilatation of a local function couples to U only. Its own dilatation counts
///    point by point, so the sum stays convex.
/// 3. The object holds Y = K^-1 K_c and the Schur complement Sigma = K_loc - K_c^T Y. So a change
///    of the set in use costs a small dense factorisation, and none of K (schur_complement.h).
///
/// Constant once built; read by any thread.
class RefinementBasis {
 public:
  /// `K` (3n x 3n): StrainStiffness of `lattice` over `tissue` with `dilatation`, plus supports in
  /// `regions`. `tissue` must resolve the finer cells. Throws InputError if K is not positive
  /// definite, or if the coupling of the functions to the lattice takes too much memory.
  /// `least_tissue`: least share (0..1) of tissue in a function, by the function's integral.
  /// `surface`: what fillings and layers have added to K; local functions get it in full.
  RefinementBasis(const Lattice& lattice, const LocalFunctionOptions& options,
                  const Quadrature& tissue, const MaterialOptions& material, Dilatation dilatation,
                  const std::vector<Quadrature>& regions, const FullStiffness& K,
                  double least_tissue = 0, const FillingsAndLayers& surface = {});

  int size() const { return finer_.size(); }  ///< N, number of functions.
  /// Returns n, the number of control points of the lattice.
  int control_points() const { return static_cast<int>(inverse_.rows()) / 3; }
  const Lattice& finer() const { return finer_; }
  /// Returns the rest positions where the functions act most, N x 3, world, m.
  const Points& centres() const { return centres_; }

  /// Returns K^-1 (3n x 3n, m/N).
  const Eigen::MatrixXd& inverse() const { return inverse_; }
  /// Returns the columns 3 a .. 3 a + 2 of Y (3n x 3).
  auto Coupling(int a) const { return coupling_.block(0, 3 * a, inverse_.rows(), 3); }
  /// Returns the memory of the largest arrays, bytes.
  double Bytes() const {
    return 8.0 * static_cast<double>(inverse_.size() + coupling_.size()) +
           12.0 * static_cast<double>(sparse_.nonZeros() + own_.nonZeros());
  }
  /// Returns Sigma_ab (3 x 3, N/m). No allocation.
  Matrix3d ReducedStiffness(int a, int b) const;

 private:
  Lattice finer_;
  Points centres_;
  Eigen::MatrixXd inverse_;
  // A function couples to U directly and through the projected dilatation: K_c = c + H^T d.
  // `sparse_` is [c; d], with few entries in c (3n x 3N) and d (m x 3N, the fillings' rows last).
  // `coupling_` is Z [c; d]
  // with Z = [I H^T]^T K^-1 [I H^T]; its first 3n rows are Y.
  Eigen::SparseMatrix<double> sparse_;
  Eigen::MatrixXd coupling_;
  Eigen::SparseMatrix<double> own_;  // 3N x 3N: K_loc, without fillings
  Eigen::MatrixXd filling_;          // L x 3N: their rows d, so that K_loc has d^T d more
};

}  // namespace hpdm
