#pragma once

#include <Eigen/Cholesky>

#include "engine/energy/elastic_energy.h"

namespace hpdm {

/// The Cholesky factorisation of an energy's Hessian. One thread; allocates once.
class NewtonFactor {
 public:
  /// `control_points`: n.
  explicit NewtonFactor(int control_points) : K_(3 * control_points, 3 * control_points) {}

  /// Factorises the Hessian at U (n x 3, m), or its positive part if it is indefinite, so a step
  /// with it descends. False if that fails too, because U is not finite.
  bool Factorise(const Points& U, ElasticEnergy* energy);

  /// Replaces R by K^-1 R: columns of 3n loads.
  void SolveInPlace(Eigen::Ref<Eigen::MatrixXd> columns) const { factor_.solveInPlace(columns); }

 private:
  FullStiffness K_;
  Eigen::LLT<FullStiffness> factor_;
};

/// Searches the length of a step by backtracking (Armijo). The potential is E(U) minus the work of
/// given forces.
///
/// 1. Returns the largest of 1, 1/2, 1/4, ... at which the potential has fallen by 1e-4 of what its
///    slope predicts.
/// 2. Returns 1 also if the slope there has fallen to a tenth.
/// 3. Returns 0 if 2^-20 is still too long.
///
/// `step` is n x 3, m; `value` is E(U). `slope` is the derivative of E along the step at U. `work`
/// is that of the given forces along the whole step, J. `trial` and `gradient` (n x 3) are scratch
/// space.
double SearchLength(const Points& U, const Points& step, double value, double slope, double work,
                    Potential* energy, Points* trial, Points* gradient);

}  // namespace hpdm
