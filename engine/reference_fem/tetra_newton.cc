#include <Eigen/LU>
#include <cmath>

#include "engine/base/error.h"
#include "engine/reference_fem/tetra_fem.h"
#include "engine/reference_fem/tetra_solver.h"

namespace hpdm {
namespace {

constexpr double kLinearTolerance = 1e-9;  // small strain: the one solve is the result
constexpr double kNewtonTolerance = 1e-4;  // finite strain: the next iteration corrects
constexpr double kSufficientDecrease = 1e-4;
constexpr int kMaxHalvings = 30;

Vector3d Apply(const TetraRow& row, const Points& u) {
  Vector3d sum = Vector3d::Zero();
  for (const auto& [node, weight] : row) sum += weight * u.row(node).transpose();
  return sum;
}

void AddForce(const TetraRow& row, const Vector3d& force, Points* forces) {
  for (const auto& [node, weight] : row) forces->row(node) += weight * force.transpose();
}

/// Newton's method for one body, with the state between its iterations.
class Newton {
 public:
  Newton(const TetraBody& body, const TetraProblem& problem, const TetraSolveOptions& options)
      : body_(body),
        problem_(problem),
        options_(options),
        solver_(body.mesh()),
        tangent_(problem.springs) {
    solution_.u = Points::Zero(problem.forces.rows(), 3);
    solution_.forces.assign(problem.loads.size(), Vector3d::Zero());
    for (std::size_t l = 0; l < problem.loads.size(); ++l) {
      if (problem.loads[l].displacement) prescribed_.push_back(l);
    }
  }

  TetraSolution Run() {
    for (int step = 1; step <= options_.load_steps; ++step) {
      share_ = static_cast<double>(step) / options_.load_steps;
      solution_.converged = false;
      for (int i = 0; i < options_.most_iterations && !solution_.converged; ++i) Iterate();
      if (!solution_.converged) break;
    }
    for (const TetraLoad& load : problem_.loads) {
      solution_.displacements.push_back(Apply(load.patch, solution_.u));
    }
    solution_.solver_iterations = solver_.iterations();
    return solution_;
  }

 private:
  /// Takes one Newton step and checks its result.
  void Iterate() {
    ++solution_.newton_iterations;
    const Points residual = Residual(solution_.u);
    const Eigen::VectorXd gaps = Gaps();
    Points step;
    for (const bool convex : {false, true}) {
      if (TryStep(convex, residual, gaps, &step)) break;
      if (convex || body_.law() == TetraLaw::kSmallStrain) {
        throw InputError(
            "tetrahedra: the stiffness is singular or indefinite; hold the body with a support");
      }
    }
    const double scale = prescribed_.empty() ? 0.0 : PrescribedScale();
    double length = 1;
    const Points full = Residual(solution_.u + step);
    const bool contracts = full.norm() <= residual.norm() / 2;
    if (!contracts &&
        gaps.norm() <= 1e-9 * scale) {  // else the step also closes the gaps and is taken in full
      const double slope = residual.cwiseProduct(step).sum();
      const double before = Potential(solution_.u);
      for (int h = 0; h < kMaxHalvings; ++h, length /= 2) {
        const double after = Potential(solution_.u + length * step);
        const double rounding = 1e-13 * std::abs(before);
        if (after <= before + kSufficientDecrease * length * slope + rounding) break;
      }
    }
    solution_.u += length * step;
    solution_.residual = Residual(solution_.u).norm() / LoadScale();
    solution_.converged = solution_.residual <= options_.tolerance && Gaps().norm() <= 1e-9 * scale;
  }

  Points Loads() const {  // applied forces and those of the multipliers
    Points forces = share_ * problem_.forces;
    for (std::size_t l = 0; l < problem_.loads.size(); ++l) {
      const TetraLoad& load = problem_.loads[l];
      if (load.force) AddForce(load.patch, share_ * *load.force, &forces);
      if (load.displacement) AddForce(load.patch, solution_.forces[l], &forces);
    }
    return forces;
  }

  double LoadScale() const {
    const double norm = Loads().norm();
    return norm > 0 ? norm : 1;
  }

  double PrescribedScale() const {
    double sum = 0;
    for (const std::size_t l : prescribed_) sum += problem_.loads[l].displacement->squaredNorm();
    return std::sqrt(sum);
  }

  Points Residual(const Points& u) const {
    Points springs;
    problem_.springs.Multiply(u, &springs);
    return body_.Gradient(u) + springs - Loads();
  }

  Eigen::VectorXd Gaps() const {
    Eigen::VectorXd gaps(static_cast<Eigen::Index>(3 * prescribed_.size()));
    for (std::size_t c = 0; c < prescribed_.size(); ++c) {
      const TetraLoad& load = problem_.loads[prescribed_[c]];
      gaps.segment<3>(static_cast<Eigen::Index>(3 * c)) =
          share_ * *load.displacement - Apply(load.patch, solution_.u);
    }
    return gaps;
  }

  /// Returns the energy of body and springs minus the work of the applied forces. Multipliers do no
  /// work along steps that do not change the prescribed rows.
  double Potential(const Points& u) const {
    Points springs;
    problem_.springs.Multiply(u, &springs);
    double potential = body_.Energy(u) + u.cwiseProduct(springs).sum() / 2 -
                       share_ * u.cwiseProduct(problem_.forces).sum();
    for (const TetraLoad& load : problem_.loads) {
      if (load.force) potential -= share_ * load.force->dot(Apply(load.patch, u));
    }
    return potential;
  }

  /// Solves K du - A^T dl = -residual, A du = gaps, and updates the multipliers.
  bool TryStep(bool convex, const Points& residual, const Eigen::VectorXd& gaps, Points* step) {
    body_.SetHessian(solution_.u, convex, &tangent_);
    tangent_.Add(problem_.springs);
    if (!solver_.Factorise(tangent_)) return false;
    const double tolerance =
        body_.law() == TetraLaw::kSmallStrain ? kLinearTolerance : kNewtonTolerance;
    *step = Points::Zero(residual.rows(), 3);
    if (!solver_.Solve(-residual, tolerance, step)) return false;
    if (prescribed_.empty()) return true;

    std::vector<Points> responses;
    Eigen::MatrixXd compliance(gaps.size(), gaps.size());
    Eigen::VectorXd missing = gaps;
    for (std::size_t c = 0; c < prescribed_.size(); ++c) {
      const TetraRow& patch = problem_.loads[prescribed_[c]].patch;
      missing.segment<3>(static_cast<Eigen::Index>(3 * c)) -= Apply(patch, *step);
      for (int axis = 0; axis < 3; ++axis) {
        Points unit = Points::Zero(residual.rows(), 3), response = unit;
        AddForce(patch, Vector3d::Unit(axis), &unit);
        if (!solver_.Solve(unit, tolerance, &response)) return false;
        for (std::size_t d = 0; d < prescribed_.size(); ++d) {
          compliance.block<3, 1>(static_cast<Eigen::Index>(3 * d),
                                 static_cast<Eigen::Index>(3 * c) + axis) =
              Apply(problem_.loads[prescribed_[d]].patch, response);
        }
        responses.push_back(std::move(response));
      }
    }
    const Eigen::VectorXd multipliers = compliance.partialPivLu().solve(missing);
    for (std::size_t r = 0; r < responses.size(); ++r) {
      const double multiplier = multipliers[static_cast<Eigen::Index>(r)];
      *step += multiplier * responses[r];
      solution_.forces[prescribed_[r / 3]][static_cast<Eigen::Index>(r % 3)] += multiplier;
    }
    return true;
  }

  const TetraBody& body_;
  const TetraProblem& problem_;
  const TetraSolveOptions& options_;
  TetraSolver solver_;
  BlockMatrix tangent_;
  std::vector<std::size_t> prescribed_;
  double share_ = 0;  // of the loads, 0..1
  TetraSolution solution_;
};

}  // namespace

double TetraSolution::Compliance(std::size_t i) const {
  return displacements[i].dot(forces[i]) / forces[i].squaredNorm();
}

TetraSolution SolveTetra(const TetraBody& body, const TetraProblem& problem,
                         const TetraSolveOptions& options) {
  TetraSolution solution = Newton(body, problem, options).Run();
  for (std::size_t l = 0; l < problem.loads.size(); ++l) {
    if (problem.loads[l].force) solution.forces[l] = *problem.loads[l].force;
  }
  return solution;
}

}  // namespace hpdm
