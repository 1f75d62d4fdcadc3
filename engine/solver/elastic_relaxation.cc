#include "engine/solver/elastic_relaxation.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "engine/base/copying.h"
#include "engine/energy/blended_energy.h"
#include "engine/solver/contact_body.h"
#include "engine/solver/enriched_compliance_solver.h"
#include "engine/solver/newton_step.h"
#include "engine/solver/secant_memory.h"

namespace hpdm {
namespace {

// m. A force that moves tissue by less does not scale the residual. Such forces occur where a tip
// only touches and where a press has ended.
constexpr double kResolved = 1e-9;
// Gradients that are remembered. On a lift of a liver by 40 mm, 30 need a third of the iterations of
// 8, and no more help.
constexpr int kSecants = 30;
// rad. The remembered gradients belong to one R, so R follows the tissue in steps.
constexpr double kLeastTurn = 0.2;

using VectorMap = Eigen::Map<Eigen::VectorXd>;
using ConstVectorMap = Eigen::Map<const Eigen::VectorXd>;

VectorMap Unknowns(Points* U) { return {U->data(), U->size()}; }
ConstVectorMap Unknowns(const Points& U) { return {U.data(), U.size()}; }

FullStiffness StiffnessAtRest(const ElasticEnergy& energy) {
  FullStiffness K;
  energy.Clone()->Hessian(Points::Zero(energy.control_points(), 3), false, &K);
  return K;
}

// Each step solves the contact problem of the quadratic model at U with H for the inverse Hessian:
//     d = -H g + H B^T f,   contacts hold at U + d.
// The first step is taken whole, so the contacts hold after it, unless the energy there is beyond all
// numbers. The later ones are as long as the potential falls: E less the work of the contacts' forces,
// which go from those of the last iteration to the new ones. Without that work a step that yields to an
// indentation or to another organ seems to climb.
class NewtonRelaxation final : public BodyRelaxation, public LatticeCompliance {
 public:
  NewtonRelaxation(const ElasticEnergy& energy, FullStiffness K, const NewtonOptions& options,
                   const RefinementBasis* functions, int slots)
      : options_(options),
        at_rest_(SolverAtRest(functions, slots, K, &schur_complement_)),
        least_load_(kResolved * K.diagonal().maxCoeff()),
        energy_(energy.Clone(), std::move(K), options.elastic_supports, schur_complement_, slots),
        secants_(3 * (energy.control_points() + slots), kSecants),
        functions_(static_cast<std::size_t>(slots), -1),
        weights_(static_cast<std::size_t>(slots), 1),
        at_(Points::Zero(energy.control_points() + slots, 3)),
        trial_(at_),
        gradient_(at_),
        trial_gradient_(at_),
        step_(at_),
        residual_(at_),
        loads_(at_),
        new_loads_(at_),
        response_(at_.size()),
        forces_response_(at_.size()),
        H0_gradient_(at_.size()),
        H0_trial_(at_.size()),
        change_(at_.size()),
        H0_columns_(at_.size(), ContactSolver::kMaxEquations),
        columns_(at_.size(), ContactSolver::kMaxEquations) {
    unit_responses_.resize(at_.size(), 3);
    load_.resize(at_.size());
    row_columns_.reserve(static_cast<std::size_t>(at_.rows()));
    row_weights_.reserve(static_cast<std::size_t>(at_.rows()));
  }

  std::unique_ptr<Relaxation> Clone() const override {
    auto copy = std::make_unique<NewtonRelaxation>(*this);
    copy->Rebind();
    return copy;
  }
  void Take(const Relaxation& other) override {
    *this = static_cast<const NewtonRelaxation&>(other);
    Rebind();
  }

  void Begin(const RelaxationInput& input, const ContactConstraints& contacts) override {
    SetActiveFunctions(contacts.refinement);
    if (input.damping != energy_.damping()) secants_.Clear();
    energy_.SetShare(input.quality.finite_strain_blend);
    if (input.start != nullptr) at_ = *input.start;
    input_ = input;
    iterates_ = contacts.size() > 0 && energy_.share() > 0;
    energy_.Damp(input.damping, input.damping > 0 ? *input.damped_from : at_);
    yield_ = 1 / (1 + input.damping);
    if (!iterates_) return;
    StartWatch();
    Turn();
    result_ = {};
    result_.converged = false;
    value_ = energy_.Gradient(at_, &gradient_);
    H0_gradient_ = Unknowns(gradient_);
    ApplyAtRest(H0_gradient_);
    response_ = H0_gradient_;
    secants_.Apply(Unknowns(gradient_), response_);
    columns_ready_ = false;
  }

  bool Linearise(int body, const ContactConstraints& contacts, ContactSolver* solver) override {
    if (!iterates_) {
      LineariseQuadratic(body, contacts, input_, at_rest_.get(), solver);
      return true;
    }
    if (!BeginsIteration()) return false;
    const auto sides = solver->sides(body);
    if (!columns_ready_) FillColumnsAtRest(contacts, sides);
    columns_ready_ = true;
    for (std::size_t e = 0; e < sides.size(); ++e) {
      const auto column = static_cast<Eigen::Index>(e);
      change_.setZero();
      AddLoad(contacts, sides[e], 1, &change_);
      columns_.col(column) = H0_columns_.col(column);
      secants_.Apply(change_, columns_.col(column));
    }
    Unknowns(&trial_) = Unknowns(at_) - response_;
    TakeOffChanges(body, contacts, trial_, solver);
    AddCompliance(body, contacts, columns_, 1, solver);
    return true;
  }

  bool Advance(int body, const ContactConstraints& contacts, const ContactSolver& solver) override {
    if (!iterates_) {
      AdvanceQuadratic(body, input_, *at_rest_, solver, &at_);
      return true;
    }
    const auto sides = solver.sides(body);
    const ContactSolver::Vector forces = solver.ForcesOn(body);
    forces_response_.noalias() =
        columns_.leftCols(static_cast<Eigen::Index>(sides.size())) * forces;
    Unknowns(&step_) = forces_response_ - response_;
    change_.setZero();
    for (std::size_t e = 0; e < sides.size(); ++e) {
      AddLoad(contacts, sides[e], forces[static_cast<Eigen::Index>(e)], &change_);
    }
    Unknowns(&new_loads_) = change_;
    const double length = TakeStep();
    ++result_.iterations;
    if (length == 0) {
      // The remembered gradients mislead: the next iteration uses the stiffness at rest alone.
      result_.converged = secants_.size() == 0 && result_.residual <= options_.tolerance;
      if (secants_.size() == 0) stalled_ = true;
      secants_.Clear();
      response_ = H0_gradient_;
      return result_.converged;
    }
    // The residual g - B^T f, and the next step without a change of forces.
    const double done = std::abs(Unknowns(new_loads_).dot(forces_response_));
    response_ = H0_gradient_;
    secants_.Apply(Unknowns(gradient_), response_);
    residual_ = gradient_ - new_loads_;
    forces_response_ = H0_gradient_;
    for (std::size_t e = 0; e < sides.size(); ++e) {
      forces_response_ -=
          forces[static_cast<Eigen::Index>(e)] * H0_columns_.col(static_cast<Eigen::Index>(e));
    }
    secants_.Apply(Unknowns(residual_), forces_response_);
    const double left = std::abs(Unknowns(residual_).dot(forces_response_));
    result_.residual = std::sqrt(left / std::max(done, least_load_ * kResolved));
    result_.converged = length == 1 && result_.residual <= options_.tolerance;
    return result_.converged;
  }

  RelaxationResult End(const RelaxationResult& solved, Points* U) override {
    *U = at_;
    if (!iterates_) return solved;
    result_.regularised = solved.regularised;
    const bool blended = energy_.share() < 1;
    result_.share_slope = blended ? energy_.ShareSlope(at_) : 0;
    if (!U->allFinite()) {  // the caller reports it; the next step starts at rest
      at_.setZero();
      secants_.Clear();
    }
    return result_;
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    if (schur_complement_ == nullptr) return;
    bool changed = false;
    for (int slot = 0; slot < active.slots(); ++slot) {
      const auto s = static_cast<std::size_t>(slot);
      if (functions_[s] == active.Function(slot) && weights_[s] == active.Weight(slot)) continue;
      if (functions_[s] != active.Function(slot)) {
        const int row = energy_.control_points() + slot;
        at_.row(row).setZero();
        secants_.ForgetRow(row);
      }
      functions_[s] = active.Function(slot);
      weights_[s] = active.Weight(slot);
      changed = true;
    }
    if (!changed) return;
    at_rest_->SetActiveFunctions(active);
    energy_.SetActiveFunctions(active);
  }

  const LatticeCompliance* compliance() const override { return this; }

  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    at_rest_->RespondTo(b, response);
    if (!iterates_) return;
    TurnColumns(response);
    if (energy_.damping() > 0) return;  // the hand feels the elastic tangent without the damper
    for (int d = 0; d < 3; ++d) {
      load_.setZero(response.rows());
      for (std::size_t i = 0; i < b.control_points.size(); ++i) {
        load_[3 * b.control_points[i] + d] += b.weights[i];
      }
      secants_.Apply(load_, response.col(d));
    }
  }

  void RespondToSet(std::span<const SparseRow> rows,
                    Eigen::Ref<Eigen::MatrixXd> responses) const override {
    if (!iterates_) return at_rest_->RespondToSet(rows, responses);
    LatticeCompliance::RespondToSet(rows, responses);
  }

  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override {
    if (!iterates_) {
      at_rest_->SolveLoads(loads);
      return;
    }
    for (Eigen::Index c = 0; c < loads.cols(); ++c) {
      load_ = loads.col(c);
      ApplyAtRest(loads.col(c));
      if (energy_.damping() > 0) {
        loads.col(c) /= yield_;
      } else {
        secants_.Apply(load_, loads.col(c));
      }
    }
  }

  void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& V,
                    Eigen::Ref<Eigen::VectorXd> U_bar) const override {
    at_rest_->AddLocalPart(V, U_bar);
  }

  Matrix3d PointCompliance(const SparseRow& b) const override {
    return at_rest_->PointCompliance(b);
  }

 private:
  // After a copy: points to the own solver's local functions.
  void Rebind() {
    const auto* refined = dynamic_cast<const EnrichedComplianceSolver*>(at_rest_.get());
    schur_complement_ = refined != nullptr ? &refined->schur_complement() : nullptr;
    energy_.Rebind(schur_complement_);
  }
  static std::unique_ptr<ComplianceSolver> SolverAtRest(const RefinementBasis* functions, int slots,
                                                        const FullStiffness& K,
                                                        const SchurComplement** schur_complement) {
    if (functions == nullptr) return MakeComplianceSolver(K);
    auto refined = std::make_unique<EnrichedComplianceSolver>(*functions, slots);
    *schur_complement = &refined->schur_complement();
    return refined;
  }

  // False if the iterations or the time are used up.
  bool BeginsIteration() {
    if (stalled_) return false;
    if (result_.iterations >=
        std::min(options_.max_iterations,
                 std::max(input_.quality.newton_iterations, kLeastNewtonIterations)))
      return false;
    result_.out_of_time = input_.stop_after > 0 ? result_.iterations == input_.stop_after
                                                : !TimeForAnother(result_.iterations);
    return !result_.out_of_time;
  }

  void StartWatch() {
    stalled_ = false;
    if (!options_.clock) return;
    started_ = iteration_began_ = options_.clock();
    longest_ = 0;
  }

  // True if another iteration, as long as the longest so far, would end within the budget.
  bool TimeForAnother(int iterations) {
    if (!options_.clock || options_.budget <= 0) return true;
    const Nanoseconds now = options_.clock();
    longest_ = std::max(longest_, now - iteration_began_);
    iteration_began_ = now;
    return iterations == 0 || ToSeconds(now - started_ + longest_) <= options_.budget;
  }

  // Lets R follow the tissue.
  void Turn() {
    const Matrix3d R = energy_.MeanRotation(at_);
    if (!R.allFinite() || !(Eigen::AngleAxisd(R * R_.transpose()).angle() > kLeastTurn)) return;
    R_ = R;
    secants_.Clear();
  }

  // Replaces columns of displacements or loads u by R u R^T, unit loads along each axis, or by R u.
  void TurnColumns(Eigen::Ref<Eigen::MatrixXd> response) const {
    for (Eigen::Index a = 0; a < response.rows() / 3; ++a) {
      const Matrix3d block = response.block<3, 3>(3 * a, 0);
      response.block<3, 3>(3 * a, 0) = R_ * block * R_.transpose();
    }
  }

  // v <- H0 v with H0 = yield R K^-1 R^T.
  void ApplyAtRest(Eigen::Ref<Eigen::VectorXd> v) const {
    const bool turned = !R_.isIdentity(0);
    for (Eigen::Index i = 0; i < v.size() && turned; i += 3) {
      v.segment<3>(i) = (R_.transpose() * v.segment<3>(i)).eval();
    }
    at_rest_->SolveLoads(v);
    for (Eigen::Index i = 0; i < v.size() && turned; i += 3) {
      v.segment<3>(i) = (R_ * v.segment<3>(i)).eval();
    }
    if (yield_ != 1) v *= yield_;
  }

  static void AddLoad(const ContactConstraints& contacts, const ContactSolver::Side& side,
                      double force, Eigen::VectorXd* load) {
    const auto row = contacts.Weights().row(side.row);
    for (Eigen::Index a = 0; a < row.size(); ++a) {
      if (row[a] != 0) load->segment<3>(3 * a) += force * row[a] * side.force_W;
    }
  }

  // Computes the responses H0 B^T to unit forces, one row of B at a time.
  void FillColumnsAtRest(const ContactConstraints& contacts,
                         std::span<const ContactSolver::Side> sides) {
    int at = -1;  // the sides of one row follow each other
    Eigen::Matrix<double, Eigen::Dynamic, 3>& unit = unit_responses_;
    for (std::size_t e = 0; e < sides.size(); ++e) {
      if (sides[e].row != at) {
        at = sides[e].row;
        row_columns_.clear();
        row_weights_.clear();
        const auto row = contacts.Weights().row(at);
        for (Eigen::Index a = 0; a < row.size(); ++a) {
          if (row[a] == 0) continue;
          row_columns_.push_back(static_cast<int>(a));
          row_weights_.push_back(row[a]);
        }
        at_rest_->RespondTo({row_columns_, row_weights_}, unit);
        TurnColumns(unit);
      }
      H0_columns_.col(static_cast<Eigen::Index>(e)).noalias() = yield_ * (unit * sides[e].force_W);
    }
  }

  // Moves along step_ and returns the length. Remembers the change of the gradient.
  double TakeStep() {
    // The contacts' work along the whole step with the forces before and after it, J.
    const double work = loads_.cwiseProduct(step_).sum();
    const double new_work = new_loads_.cwiseProduct(step_).sum();
    const double slope = gradient_.cwiseProduct(step_).sum() - work;
    // Differences at the level of round-off do not shorten the step.
    const double slack = 1e-12 * std::abs(value_);
    double length = 1, value = 0;
    for (; length > kLeastLength; length /= 2) {
      trial_ = at_ + length * step_;
      value = energy_.Gradient(trial_, &trial_gradient_);
      if (result_.iterations == 0) {
        if (std::isfinite(value) || !step_.allFinite()) break;
        continue;
      }
      const double done = length * work + length * length / 2 * (new_work - work);
      if (value - value_ - done <= kSufficient * length * slope + slack) break;
      // Near the minimum, round-off hides the energy's change before it hides its slope.
      const double left =
          trial_gradient_.cwiseProduct(step_).sum() - work - length * (new_work - work);
      if (std::abs(left) <= kFlattened * std::abs(slope)) break;
    }
    if (!(length > kLeastLength) || (!std::isfinite(value) && result_.iterations > 0)) return 0;
    at_ = trial_;
    value_ = value;
    loads_ += (result_.iterations == 0 ? 1 : length) * (new_loads_ - loads_);
    H0_trial_ = Unknowns(trial_gradient_);
    ApplyAtRest(H0_trial_);
    change_ = Unknowns(trial_gradient_) - Unknowns(gradient_);
    Unknowns(&step_) *= length;
    H0_gradient_ = H0_trial_ - H0_gradient_;  // H0 times the change
    secants_.Add(Unknowns(step_), change_, H0_gradient_);
    H0_gradient_ = H0_trial_;
    gradient_ = trial_gradient_;
    return length;
  }

  static constexpr double kSufficient = 1e-4;
  static constexpr double kFlattened = 0.1;
  static constexpr double kLeastLength = 1e-4;

  NewtonOptions options_;
  const SchurComplement* schur_complement_ = nullptr;  // at_rest_'s
  Cloned<ComplianceSolver> at_rest_;                   // K^-1
  double least_load_;                                  // N: moves tissue by kResolved
  BlendedEnergy energy_;
  SecantMemory secants_;
  Matrix3d R_ = Matrix3d::Identity();
  double yield_ = 1;             // the damper's share of H0
  std::vector<int> functions_;   // in each slot
  std::vector<double> weights_;  // of each slot
  // (n + slots) x 3 each:
  Points at_;  // m: where the last step ended
  Points trial_, gradient_, trial_gradient_, step_, residual_;
  Points loads_, new_loads_;  // N: B^T f of the last iteration and of the present one
  // 3(n + slots) each:
  Eigen::VectorXd response_;         // m: H g
  Eigen::VectorXd forces_response_;  // m
  Eigen::VectorXd H0_gradient_, H0_trial_, change_;
  WorkMatrix H0_columns_, columns_;  // 3(n + slots) x equations: H0 B^T and H B^T
  Eigen::Matrix<double, Eigen::Dynamic, 3> unit_responses_;
  std::vector<int> row_columns_;
  std::vector<double> row_weights_;
  mutable Eigen::VectorXd load_;
  bool columns_ready_ = false;
  bool stalled_ = false;     // no step descends
  RelaxationInput input_;    // of the present step
  bool iterates_ = false;    // the present step is not quadratic
  double value_ = 0;         // energy at at_, J
  RelaxationResult result_;  // of the present step
  Nanoseconds started_ = 0, iteration_began_ = 0, longest_ = 0;
};

}  // namespace

std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options,
                                                 const FullStiffness* K,
                                                 const RefinementBasis* functions, int slots) {
  return std::make_unique<NewtonRelaxation>(energy, K != nullptr ? *K : StiffnessAtRest(energy),
                                            options, functions, slots);
}

}  // namespace hpdm
