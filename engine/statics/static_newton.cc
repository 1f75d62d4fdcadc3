#include "engine/statics/static_newton.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/base/check.h"
#include "engine/solver/newton_step.h"

namespace hpdm {
namespace {

using Vector = Eigen::VectorXd;

// Largest last step over U such that the next one, its square, is round-off.
constexpr double kSettledStep = 1e-7;
using VectorMap = Eigen::Map<Vector>;

VectorMap AsVector(Points* U) { return {U->data(), U->size()}; }

// Finds one equilibrium after another, each from the last one.
class StaticNewton {
 public:
  StaticNewton(const StaticLoadRows& loads, ElasticEnergy* energy,
               const StaticNewtonOptions& options)
      : energy_(energy),
        options_(options),
        loads_(loads),
        factor_(static_cast<int>(loads.rows.rows() / 3)),
        gradient_(loads.rows.rows() / 3, 3),
        step_(gradient_),
        trial_(gradient_),
        trial_gradient_(gradient_) {
    const Eigen::Index equations = loads.rows.cols();
    HPDM_CHECK(loads.rows.rows() >= 3 * energy->control_points());
    HPDM_CHECK(loads.forces.size() == equations && loads.moves.size() == equations);
    for (Eigen::Index e = 0; e < equations; ++e) {
      if (loads.held[static_cast<std::size_t>(e)]) held_.push_back(e);
    }
    held_rows_ = loads.rows(Eigen::all, held_);
    state_.U = Points::Zero(loads.rows.rows() / 3, 3);
    state_.forces = Vector::Zero(equations);
  }

  StaticNewtonSolution Solve() {
    double size = 1.0 / options_.load_steps;
    for (int halvings = 0; state_.share < 1 && halvings <= options_.max_halvings &&
                           state_.iterations < options_.max_total;) {
      const StaticNewtonSolution before = state_;
      state_.share = state_.share + size > 1 - 1e-9 ? 1 : state_.share + size;
      if (Equilibrate()) {
        halvings = 0;
        continue;
      }
      const int iterations = state_.iterations;
      state_ = before;
      state_.iterations = iterations;
      size /= 2;
      ++halvings;
    }
    return state_;
  }

 private:
  // True if the equilibrium of this share is found.
  bool Equilibrate() {
    given_ = loads_.forces * state_.share;
    given_(held_).setZero();
    // Intermediate load steps need only give a good start for the next.
    const double tolerance =
        state_.share < 1 ? std::max(options_.tolerance, 1e-3) : options_.tolerance;
    double value = energy_->Gradient(state_.U, &gradient_);
    for (int i = 0; i < options_.max_iterations && state_.iterations < options_.max_total; ++i) {
      ++state_.iterations;
      if (!factor_.Factorise(state_.U, energy_)) return false;
      SolveStep();
      // The first step of a load step moves the held points and is taken whole.
      double length = 1;
      if (i > 0 || held_.empty()) {
        const double slope = gradient_.cwiseProduct(step_).sum();
        const double work = (loads_.rows * state_.forces).dot(AsVector(&step_));
        length =
            SearchLength(state_.U, step_, value, slope, work, energy_, &trial_, &trial_gradient_);
        if (length == 0) return false;
      }
      state_.U += length * step_;
      value = energy_->Gradient(state_.U, &gradient_);
      if (!std::isfinite(value)) return false;
      const Vector load = loads_.rows * state_.forces;
      const double size = load.norm();
      state_.residual = size > 0 ? (AsVector(&gradient_) - load).norm() / size : 0;
      // A small residual alone is not enough: functions with little tissue hardly resist and may
      // still be far from equilibrium.
      const bool settled = length * step_.norm() <= kSettledStep * state_.U.norm();
      if (length == 1 && state_.residual <= tolerance && (settled || state_.share < 1)) return true;
    }
    return false;
  }

  // Solves K d + g = R f with the given forces, and held forces such that R_h^T (U + d) is as
  // given.
  void SolveStep() {
    Eigen::MatrixXd columns(held_rows_.rows(), 1 + held_rows_.cols());
    columns.col(0) = loads_.rows * given_ - AsVector(&gradient_);
    columns.rightCols(held_rows_.cols()) = held_rows_;
    factor_.SolveInPlace(columns);
    state_.forces = given_;
    VectorMap step = AsVector(&step_);
    step = columns.col(0);
    if (held_.empty()) return;
    const auto responses = columns.rightCols(held_rows_.cols());
    const Vector wanted = state_.share * loads_.moves(held_);
    const Vector missing = wanted - held_rows_.transpose() * (AsVector(&state_.U) + step) -
                           Vector(loads_.local * given_)(held_);
    const Eigen::MatrixXd compliance =
        held_rows_.transpose() * responses + loads_.local(held_, held_);
    const Vector found = compliance.ldlt().solve(missing);
    state_.forces(held_) = found;
    step += responses * found;
  }

  ElasticEnergy* energy_;
  StaticNewtonOptions options_;
  const StaticLoadRows& loads_;
  std::vector<Eigen::Index> held_;
  Eigen::MatrixXd held_rows_;  // 3n x h
  NewtonFactor factor_;
  StaticNewtonSolution state_;
  Vector given_;     // e: given forces at this share
  Points gradient_;  // n x 3, at state_.U
  Points step_, trial_, trial_gradient_;
};

}  // namespace

StaticNewtonSolution SolveStaticLoads(const StaticLoadRows& loads, ElasticEnergy* energy,
                                      const StaticNewtonOptions& options) {
  return StaticNewton(loads, energy, options).Solve();
}

}  // namespace hpdm
