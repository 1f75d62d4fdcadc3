#pragma once

#include <Eigen/Cholesky>

#include "engine/energy/elastic_energy.h"

namespace hpdm {

/// The Hessian of an energy as Cholesky factors. One thread; allocates once.
class NewtonFactor {
 public:
  /// `control_points`: n.
  explicit NewtonFactor(int control_points) : K_(3 * control_points, 3 * control_points) {}

  /// At U (n x 3, m); where the Hessian is indefinite, its positive part, so that a step with it
  /// goes downhill. False when that fails too: U is not finite.
  bool Factorise(const Points& U, ElasticEnergy* energy);

  /// R -> K^-1 R in place: columns of 3n.
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> columns) const { factor_.solveInPlace(columns); }

 private:
  FullStiffness K_;
  Eigen::LLT<FullStiffness> factor_;
};

/// Backtracking line search (Armijo): the largest of 1, 1/2, 1/4, ... such that from U along `step`
/// (n x 3, m) the potential E(U) - work has fallen by 1e-4 of what its slope promises, or 1 when
/// its slope has fallen to a tenth there; 0 when 2^-20 is still too long. `value` is E(U), `slope`
/// the derivative of E along the step at U, `work` (J) what given forces do along the whole step.
/// `trial` and `gradient` (n x 3) are scratch.
double SearchLength(const Points& U, const Points& step, double value, double slope, double work,
                    Potential* energy, Points* trial, Points* gradient);

}  // namespace hpdm
