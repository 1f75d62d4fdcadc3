#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "engine/lattice/active_refinement.h"
#include "engine/solver/refinement_basis.h"

namespace hpdm {

/// The local functions in use beside a lattice (refinement_basis.h). With the displacements
/// U_bar = U + Y V (n x 3, m) that the lattice would have without them, the energy falls apart,
///     1/2 [U V] [K K_c; K_c^T K_loc] [U V]^T = 1/2 U_bar^T K U_bar + 1/2 V^T Sigma V,
/// and loads (f, g) on (U, V) become f on U_bar and g - Y^T f on V. With finite strain the energy
/// of U_bar takes the place of its first part: what the local functions add stays that of small
/// strain.
///
/// A function of weight w (active_refinement.h) has Sigma_ii / w in place of its own block
/// Sigma_ii, so that alone it would move w times as far.
///
/// Owned by one thread; methods allocate nothing.
class SchurComplement {
 public:
  SchurComplement(const RefinementBasis& functions, int slots);

  const RefinementBasis& functions() const { return functions_; }
  /// Takes the functions in use and their weights: 3 x 3 blocks of Sigma for each slot that
  /// changed, and where anything has, the factorisation, 0.2 (3 slots)^3 operations.
  void SetActiveFunctions(const ActiveRefinement& active);

  /// `g` (3 slots, N): g - Y^T f in its place, with f (3n, N).
  void Reduce(const Eigen::Ref<const Eigen::VectorXd>& f, Eigen::Ref<Eigen::VectorXd> g) const {
    g.noalias() -= coupling_.transpose() * f;
  }
  /// `g` (3 slots, N): Sigma^-1 g in its place.
  void Solve(Eigen::Ref<Eigen::VectorXd> g) const { factor_.solveInPlace(g); }
  /// `U_bar` (3n, m): U_bar + factor Y V in its place.
  void AddCoupling(double factor, const Eigen::Ref<const Eigen::VectorXd>& V,
                   Eigen::Ref<Eigen::VectorXd> U_bar) const {
    U_bar.noalias() += factor * (coupling_ * V);
  }
  /// Sigma (3 slots x 3 slots, N/m), weights included.
  const Eigen::MatrixXd& stiffness() const { return regular_; }

 private:
  bool TakeSlots(const ActiveRefinement& active);

  const RefinementBasis& functions_;
  std::vector<int> function_;   // of each slot, or -1
  std::vector<double> weight_;  // of each slot
  std::vector<bool> stale_;
  Eigen::MatrixXd coupling_;  // 3n x 3 slots: Y
  Eigen::MatrixXd reduced_;   // 3 slots x 3 slots: Sigma at full weight, 1 in an empty slot
  Eigen::MatrixXd regular_;   // Sigma with weights, kept from being singular
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace hpdm
