#include "engine/solver/newton_step.h"

#include <cmath>

namespace hpdm {

bool NewtonFactor::Factorise(const Points& U, ElasticEnergy* energy) {
  for (const bool semi_definite : {false, true}) {
    energy->Hessian(U, semi_definite, &K_);
    // Semi-definite parts may leave a direction without any stiffness.
    if (semi_definite) K_.diagonal() *= 1 + 1e-9;
    factor_.compute(K_);
    // A NaN is not below zero, so the factorisation takes it for positive. It reaches the diagonal.
    if (factor_.info() == Eigen::Success && factor_.matrixLLT().diagonal().allFinite()) return true;
  }
  return false;
}

double SearchLength(const Points& U, const Points& step, double value, double slope, double work,
                    Potential* energy, Points* trial, Points* gradient) {
  constexpr double kSufficient = 1e-4;
  constexpr double kFlattened = 0.1;
  constexpr int kMaxHalvings = 20;
  // Differences at the level of round-off do not shorten the step.
  const double slack = 1e-13 * std::abs(value);
  double length = 1;
  for (int halving = 0; halving <= kMaxHalvings; ++halving, length /= 2) {
    *trial = U + length * step;
    const double change = energy->Energy(*trial) - value - length * work;
    if (change <= kSufficient * length * (slope - work) + slack) return length;
    if (length < 1) continue;
    // Near the minimum, round-off hides the energy's change before it hides its slope.
    energy->Gradient(*trial, gradient);
    const double slope_there = gradient->cwiseProduct(step).sum() - work;
    if (std::abs(slope_there) <= kFlattened * std::abs(slope - work)) return length;
  }
  return 0;
}

}  // namespace hpdm
