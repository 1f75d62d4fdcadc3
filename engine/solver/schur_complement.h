#pragma once

#include <Eigen/Cholesky>
#include <vector>

#include "engine/lattice/active_refinement.h"
#include "engine/solver/refinement_basis.h"

namespace hpdm {

/// The local functions in use beside a lattice (refinement_basis.h).
///
/// 1. With U_bar = U + Y V (n x 3, m), the displacements without local functions, the energy
///    splits:
///        1/2 [U V] [K K_c; K_c^T K_loc] [U V]^T = 1/2 U_bar^T K U_bar + 1/2 V^T Sigma V.
/// 2. Loads (f, g) on (U, V) become f on U_bar and g - Y^T f on V.
/// 3. With finite strain the energy of U_bar replaces 1/2 U_bar^T K U_bar. The local functions stay
///    linear.
/// 4. A function of weight w (active_refinement.h) has the own block Sigma_ii / w instead of
///    Sigma_ii, so alone it would move w times as far.
///
/// Owned by one thread; methods allocate nothing.
class SchurComplement {
 public:
  SchurComplement(const RefinementBasis& functions, int slots);

  const RefinementBasis& functions() const { return *functions_; }
  /// Sets the functions in use and their weights. Computes the 3 x 3 blocks of Sigma for each slot
  /// that changed, and after any change the factorisation: 0.2 (3 slots)^3 operations.
  void SetActiveFunctions(const ActiveRefinement& active);

  /// Replaces `g` (3 slots, N) by g - Y^T f, with f (3n, N).
  void Reduce(const Eigen::Ref<const Eigen::VectorXd>& f, Eigen::Ref<Eigen::VectorXd> g) const;
  /// Does the same for `weight` (1) at one control point along each axis: `g` is 3 slots x 3.
  void ReducePoint(int point, double weight, Eigen::Ref<Eigen::MatrixXd> g) const;
  /// Replaces `g` (3 slots, N) by Sigma^-1 g.
  void Solve(Eigen::Ref<Eigen::VectorXd> g) const { factor_.solveInPlace(g); }
  /// Adds factor Y V to `U_bar` (3n, m).
  void AddCoupling(double factor, const Eigen::Ref<const Eigen::VectorXd>& V,
                   Eigen::Ref<Eigen::VectorXd> U_bar) const;
  /// Returns Sigma (3 slots x 3 slots, N/m), weights included.
  const Eigen::MatrixXd& stiffness() const { return regular_; }

 private:
  bool TakeSlots(const ActiveRefinement& active);

  const RefinementBasis* functions_;
  std::vector<int> function_;   // in each slot, or -1
  std::vector<double> weight_;  // of the function in each slot
  std::vector<bool> stale_;
  mutable Eigen::VectorXd moved_;  // 3n, m: Y V
  Eigen::MatrixXd reduced_;        // 3 slots x 3 slots: Sigma at full weight, 1 in an empty slot
  Eigen::MatrixXd regular_;        // Sigma with weights, regularised
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

}  // namespace hpdm
