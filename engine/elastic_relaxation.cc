#include "engine/elastic_relaxation.h"

#include <algorithm>
#include <utility>

#include "engine/damped_energy.h"
#include "engine/lattice_response.h"
#include "engine/newton_step.h"

namespace hpdm {
namespace {

// m. A force that moves tissue by less is none: where a tip only touches, and where a press has let
// go, the residual must not be relative to it.
constexpr double kResolved = 1e-9;

// Each Newton step solves the contact problem of the energy's quadratic model at U:
//     K d + g = B^T f,   contacts hold at U + d,
// as d = -K^-1 g + K^-1 B^T f in the contacts' compliance space. The first step is taken whole, so
// that the contacts hold from there on; points that obey them are a convex set, in which the later
// steps go downhill, as far as the energy falls.
class NewtonRelaxation final : public Relaxation, public LatticeCompliance {
 public:
  NewtonRelaxation(const ElasticEnergy& energy, const NewtonOptions& options)
      : energy_(energy.Clone()),
        options_(options),
        factor_(energy.control_points()),
        U_(Points::Zero(energy.control_points(), 3)),
        trial_(U_),
        gradient_(U_),
        step_(U_),
        load_(U_),
        columns_(3 * U_.rows(), 1 + ContactProblem::kMaxEquations) {
    at_rest_ = MakeLatticeResponse(energy_.stiffness_at_rest());
    least_load_ = kResolved * energy_.stiffness_at_rest().diagonal().maxCoeff();
  }

  RelaxationResult Relax(ContactSet* contacts, Points* U) override {
    RelaxationResult result;
    const int recorded_end = std::exchange(stop_after_, 0);
    has_tangent_ = contacts->size() > 0;
    if (!has_tangent_) {
      U_.setZero();
      energy_.Damp(0, U_);
      *U = U_;
      return result;
    }
    result.converged = false;
    StartWatch();
    double energy = energy_.Gradient(U_, &gradient_);
    while (!result.converged && result.iterations < options_.max_iterations) {
      result.out_of_time =
          recorded_end > 0 ? result.iterations == recorded_end : !TimeForAnother(result.iterations);
      if (result.out_of_time) break;
      if (!factor_.Factorise(U_, &energy_)) {
        has_tangent_ = false;
        break;
      }
      result.regularised = SolveStep(*contacts).regularised;
      const double length = result.iterations == 0 ? 1 : Search(energy);
      U_ += length * step_;
      ++result.iterations;
      energy = energy_.Gradient(U_, &gradient_);
      problem_.WriteForces(contacts);
      result.residual = Residual(*contacts);
      result.converged = length == 1 && result.residual <= options_.tolerance;
    }
    StopDamping();
    *U = U_;
    if (!U_.allFinite()) U_.setZero();  // the caller reports it; the next step starts at rest
    return result;
  }

  void StopNextAfter(int iterations) override { stop_after_ = iterations; }

  void RestartFrom(const Points& U) override { U_ = U; }

  bool DampNext(double damping, const Points& from) override {
    energy_.Damp(damping, from);
    U_ = from;
    return true;
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
    factor_.SolveInPlace(response);
  }

  Matrix3d PointCompliance(const SparseRow& b) const override {
    return at_rest_->PointCompliance(b);
  }

 private:
  // The hand feels the elastic tangent, as of an energy that is quadratic.
  void StopDamping() {
    if (!(energy_.damping() > 0)) return;
    energy_.Damp(0, U_);
    has_tangent_ = has_tangent_ && factor_.Factorise(U_, &energy_);
  }

  void StartWatch() {
    if (!options_.clock) return;
    started_ = iteration_began_ = options_.clock();
    longest_ = 0;
  }

  // Whether an iteration as long as the longest so far would end within the budget.
  bool TimeForAnother(int iterations) {
    if (!options_.clock || options_.budget <= 0) return true;
    const Nanoseconds now = options_.clock();
    longest_ = std::max(longest_, now - iteration_began_);
    iteration_began_ = now;
    return iterations == 0 || ToSeconds(now - started_ + longest_) <= options_.budget;
  }

  // The step d and the forces f.
  RelaxationResult SolveStep(const ContactSet& contacts) {
    problem_.Build(contacts);
    const int equations = problem_.size();
    Eigen::Map<Points>(columns_.col(0).data(), U_.rows(), 3) = -gradient_;
    for (int e = 0; e < equations; ++e) {
      Eigen::Map<Points>(columns_.col(1 + e).data(), U_.rows(), 3).noalias() =
          contacts.Weights().row(problem_[e].row).transpose() * problem_[e].force_W.transpose();
    }
    auto columns = columns_.leftCols(1 + equations);
    factor_.SolveInPlace(columns);

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

  double Search(double energy) {
    const double slope = gradient_.cwiseProduct(step_).sum();
    return SearchLength(U_, step_, energy, slope, 0, &energy_, &trial_, &load_);
  }

  double Residual(const ContactSet& contacts) {
    load_.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      load_.noalias() += contacts.Weights().row(i).transpose() * contacts[i].force_W.transpose();
    }
    return (gradient_ - load_).norm() / std::max(load_.norm(), least_load_);
  }

  DampedEnergy energy_;
  NewtonOptions options_;
  NewtonFactor factor_;
  Points U_;                                  // n x 3: where the last step ended
  Points trial_;                              // n x 3
  Points gradient_;                           // n x 3, N: dE/dU at U_
  Points step_;                               // n x 3: d
  Points load_;                               // n x 3, N: B^T f
  Eigen::MatrixXd columns_;                   // 3n x (1 + equations): -K^-1 g, then the responses
  bool has_tangent_ = false;                  // factor_ holds the last step's
  std::unique_ptr<LatticeResponse> at_rest_;  // K^-1 of U = 0
  ContactProblem problem_;
  double least_load_ = 0;  // N: smaller ones count as this in the residual
  Nanoseconds started_ = 0, iteration_began_ = 0, longest_ = 0;
  int stop_after_ = 0;  // iterations of the next Relax; 0: as the options say
};

}  // namespace

std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options) {
  return std::make_unique<NewtonRelaxation>(energy, options);
}

}  // namespace hpdm
