#include "engine/elastic_relaxation.h"

#include <Eigen/Cholesky>
#include <utility>

#include "engine/lattice_response.h"

namespace hpdm {
namespace {

// Each Newton step solves the contact problem of the energy's quadratic model at U:
//     K d + g = B^T f,   contacts hold at U + d,
// as d = -K^-1 g + K^-1 B^T f in the contacts' compliance space. The first step is taken whole, so
// that the contacts hold from there on; points that obey them are a convex set, in which the later
// steps go downhill, as far as the energy falls.
class NewtonRelaxation final : public Relaxation, public LatticeCompliance {
 public:
  NewtonRelaxation(FiniteStrainEnergy energy, const NewtonOptions& options)
      : energy_(std::move(energy)),
        options_(options),
        U_(Points::Zero(energy_.control_points(), 3)),
        trial_(U_),
        gradient_(U_),
        step_(U_),
        load_(U_),
        K_(3 * U_.rows(), 3 * U_.rows()),
        columns_(3 * U_.rows(), 1 + ContactProblem::kMaxEquations) {
    energy_.Hessian(U_, false, &K_);
    at_rest_ = MakeLatticeResponse(K_);
  }

  RelaxationResult Relax(ContactSet* contacts, Points* U) override {
    RelaxationResult result;
    has_tangent_ = contacts->size() > 0;
    if (!has_tangent_) {
      U_.setZero();
      *U = U_;
      return result;
    }
    result.converged = false;
    double energy = energy_.Gradient(U_, &gradient_);
    while (!result.converged && result.iterations < options_.max_iterations) {
      Factorise();
      result.regularised = SolveStep(*contacts).regularised;
      const bool whole = result.iterations == 0 || Search(energy);
      if (whole) U_ += step_;
      ++result.iterations;
      energy = energy_.Gradient(U_, &gradient_);
      problem_.WriteForces(contacts);
      result.residual = Residual(*contacts);
      result.converged = whole && result.residual <= options_.tolerance;
    }
    *U = U_;
    if (!U_.allFinite()) U_.setZero();  // the caller reports it; the next step starts at rest
    return result;
  }

  const LatticeCompliance* compliance() const override { return this; }

  // With the last Newton step's tangent.
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    if (!has_tangent_) {
      at_rest_->RespondTo(b, response);
      return;
    }
    response.setZero();
    for (std::size_t i = 0; i < b.control_points.size(); ++i) {
      for (int d = 0; d < 3; ++d) response(3 * b.control_points[i] + d, d) += b.weights[i];
    }
    factor_.solveInPlace(response);
  }

  Matrix3d PointCompliance(const SparseRow& b) const override {
    return at_rest_->PointCompliance(b);
  }

 private:
  // The Hessian at U as Cholesky factors, projected only when it must be.
  void Factorise() {
    for (const bool semi_definite : {false, true}) {
      energy_.Hessian(U_, semi_definite, &K_);
      // Semi-definite tangents may leave a direction without any stiffness.
      if (semi_definite) K_.diagonal() *= 1 + 1e-9;
      factor_.compute(K_);
      if (factor_.info() == Eigen::Success) return;
    }
  }

  // The step d and the forces f.
  RelaxationResult SolveStep(const ContactSet& contacts) {
    problem_.Build(contacts);
    const int equations = problem_.size();
    Eigen::Map<Points>(columns_.col(0).data(), U_.rows(), 3) = -gradient_;
    for (int e = 0; e < equations; ++e) {
      Eigen::Map<Points>(columns_.col(1 + e).data(), U_.rows(), 3).noalias() =
          contacts.Weights().row(problem_[e].row).transpose() * problem_[e].axis_W.transpose();
    }
    auto columns = columns_.leftCols(1 + equations);
    factor_.solveInPlace(columns);

    const Eigen::Map<const Points> free_step(columns_.col(0).data(), U_.rows(), 3);
    trial_ = U_ + free_step;
    for (int e = 0; e < equations; ++e) {
      problem_.change()[e] -=
          problem_[e].axis_W.dot((contacts.Weights().row(problem_[e].row) * trial_).transpose());
    }
    const auto response = columns_.middleCols(1, equations);
    FillCompliance(contacts, response, &problem_);
    const RelaxationResult result = problem_.Solve();
    Eigen::Map<Eigen::VectorXd> step(step_.data(), step_.size());
    step = columns_.col(0);
    step.noalias() += response * problem_.forces();
    return result;
  }

  // Backtracks until the energy has fallen by 1e-4 of what its slope promises (Armijo). True for
  // the whole step, which is left to the caller; else moves U itself.
  bool Search(double energy) {
    const double slope = gradient_.cwiseProduct(step_).sum();
    double length = 1;
    for (int halving = 0; halving < 12; ++halving, length /= 2) {
      trial_ = U_ + length * step_;
      // Differences at the level of round-off are no reason to stop.
      const double slack = 1e-13 * energy;
      if (energy_.Energy(trial_) <= energy + 1e-4 * length * slope + slack) break;
    }
    if (length == 1) return true;
    U_ = trial_;
    return false;
  }

  double Residual(const ContactSet& contacts) {
    load_.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      load_.noalias() += contacts.Weights().row(i).transpose() * contacts[i].force_W.transpose();
    }
    const double load = load_.norm();
    return load > 0 ? (gradient_ - load_).norm() / load : 0;
  }

  FiniteStrainEnergy energy_;
  NewtonOptions options_;
  Points U_;                 // n x 3: where the last step ended
  Points trial_;             // n x 3
  Points gradient_;          // n x 3, N: dE/dU at U_
  Points step_;              // n x 3: d
  Points load_;              // n x 3, N: B^T f
  FullStiffness K_;          // 3n x 3n
  Eigen::MatrixXd columns_;  // 3n x (1 + equations): -K^-1 g, then the responses
  Eigen::LLT<FullStiffness> factor_;
  bool has_tangent_ = false;                  // factor_ holds the last step's
  std::unique_ptr<LatticeResponse> at_rest_;  // K^-1 of U = 0
  ContactProblem problem_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeNewtonRelaxation(const FiniteStrainEnergy& energy,
                                                 const NewtonOptions& options) {
  return std::make_unique<NewtonRelaxation>(energy, options);
}

}  // namespace hpdm
