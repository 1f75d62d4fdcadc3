#include "engine/solver/elastic_relaxation.h"

#include <algorithm>

#include "engine/base/copying.h"
#include "engine/energy/blended_energy.h"
#include "engine/solver/contact_body.h"
#include "engine/solver/enriched_compliance_solver.h"
#include "engine/solver/newton_step.h"

namespace hpdm {
namespace {

// m. A force that moves tissue by less does not scale the residual. Such forces occur where a tip
// only touches and where a press has ended.
constexpr double kResolved = 1e-9;

using VectorMap = Eigen::Map<Eigen::VectorXd>;
using ConstVectorMap = Eigen::Map<const Eigen::VectorXd>;

VectorMap Unknowns(Points* U) { return {U->data(), U->size()}; }

// The energy of U_bar and V together (schur_complement.h), (n + slots) x 3, with the damper on
// both.
class StepPotential final : public Potential {
 public:
  StepPotential(BlendedEnergy* energy, const SchurComplement* schur_complement, int slots)
      : energy_(energy),
        schur_complement_(schur_complement),
        U_bar_(Points::Zero(energy->control_points(), 3)),
        gradient_(U_bar_),
        V_damped_(Eigen::VectorXd::Zero(3 * slots)),
        load_(V_damped_) {}

  // For the potential of a copied relaxation.
  void Rebind(BlendedEnergy* energy, const SchurComplement* schur_complement) {
    energy_ = energy;
    schur_complement_ = schur_complement;
  }

  void Damp(const Eigen::Ref<const Eigen::VectorXd>& V_from) { V_damped_ = V_from; }
  const Eigen::VectorXd& damped_from() const { return V_damped_; }

  double Energy(const Points& at) override {
    U_bar_ = at.topRows(U_bar_.rows());
    return energy_->Energy(U_bar_) + LocalEnergy(at);
  }
  double Gradient(const Points& at, Points* gradient) override {
    U_bar_ = at.topRows(U_bar_.rows());
    double energy = energy_->Gradient(U_bar_, &gradient_);
    gradient->topRows(U_bar_.rows()) = gradient_;
    if (load_.size() == 0) return energy;
    energy += LocalEnergy(at);
    Unknowns(gradient).tail(load_.size()) = load_;
    return energy;
  }
  double ShareSlope() { return energy_->ShareSlope(U_bar_); }

 private:
  // Returns the energy of V and fills load_ with its gradient.
  double LocalEnergy(const Points& at) {
    if (load_.size() == 0) return 0;
    const auto V = ConstVectorMap(at.data(), at.size()).tail(load_.size());
    load_.noalias() = schur_complement_->stiffness() * V;
    double energy = V.dot(load_) / 2;
    if (energy_->damping() > 0) {
      away_.noalias() = schur_complement_->stiffness() * (V - V_damped_);
      energy += energy_->damping() / 2 * (V - V_damped_).dot(away_);
      load_ += energy_->damping() * away_;
    }
    return energy;
  }

  BlendedEnergy* energy_;
  const SchurComplement* schur_complement_;  // nullptr without slots
  Points U_bar_, gradient_;                  // n x 3
  Eigen::VectorXd V_damped_;                 // 3 slots, m: where the damper holds V
  Eigen::VectorXd load_;                     // 3 slots, N
  Eigen::VectorXd away_;                     // 3 slots, N
};

// Each Newton step solves the contact problem of the energy's quadratic model at (U_bar, V):
//     K d + g = B^T f,   Sigma V = (B_V - B Y)^T f,   contacts hold at (U_bar + d, V)
// as d = -K^-1 g + K^-1 B^T f in the contacts' compliance space, to which V adds its own. The first
// step is taken whole, so the contacts hold after it. The points that satisfy them are a convex
// set, in which the later steps descend as far as the energy falls.
class NewtonRelaxation final : public BodyRelaxation, public LatticeCompliance {
 public:
  NewtonRelaxation(const ElasticEnergy& energy, const NewtonOptions& options,
                   const RefinementBasis* functions, int slots)
      : energy_(energy.Clone(), options.elastic_supports),
        options_(options),
        n_(energy.control_points()),
        at_rest_(SolverAtRest(functions, slots, energy_, &schur_complement_)),
        potential_(&energy_, schur_complement_, slots),
        factor_(n_),
        at_(Points::Zero(n_ + slots, 3)),
        trial_(at_),
        gradient_(at_),
        step_(at_),
        load_(at_),
        U_bar_(Points::Zero(n_, 3)),
        columns_(3 * at_.rows(), 1 + ContactSolver::kMaxEquations) {
    least_load_ = kResolved * energy_.stiffness_at_rest().diagonal().maxCoeff();
  }

  std::unique_ptr<Relaxation> Clone() const override {
    auto copy = std::make_unique<NewtonRelaxation>(*this);
    const auto* refined = dynamic_cast<const EnrichedComplianceSolver*>(copy->at_rest_.get());
    copy->schur_complement_ = refined != nullptr ? &refined->schur_complement() : nullptr;
    copy->potential_.Rebind(&copy->energy_, copy->schur_complement_);
    return copy;
  }

  void Begin(const RelaxationInput& input, const ContactConstraints& contacts) override {
    SetActiveFunctions(contacts.refinement);
    energy_.SetShare(input.quality.finite_strain_blend);
    if (input.start != nullptr) Enter(*input.start);
    input_ = input;
    has_tangent_ = iterates_ = contacts.size() > 0 && energy_.share() > 0;
    if (contacts.size() == 0) energy_.Damp(0, U_bar_);
    if (!iterates_) return;
    StartDamping();
    StartWatch();
    result_ = {};
    result_.converged = false;
    value_ = potential_.Gradient(at_, &gradient_);
  }

  bool Linearise(int body, const ContactConstraints& contacts, ContactSolver* solver) override {
    if (!iterates_) {
      LineariseQuadratic(body, contacts, input_, at_rest_.get(), solver);
      return true;
    }
    if (!BeginsIteration()) return false;
    U_bar_ = at_.topRows(n_);
    if (!factor_.Factorise(U_bar_, &energy_)) {
      has_tangent_ = false;
      return false;
    }
    RespondAtTangent(body, contacts, solver);
    return true;
  }

  bool Advance(int body, const ContactConstraints& contacts, const ContactSolver& solver) override {
    if (!iterates_) {
      AdvanceQuadratic(body, input_, *at_rest_, solver, &at_);
      return true;
    }
    const Eigen::Index slots = at_.size() - 3 * n_;
    VectorMap step = Unknowns(&step_);
    step << columns_.col(0).head(3 * n_), Eigen::VectorXd::Zero(slots);
    step.noalias() += Responses(solver.sides(body).size()) * solver.ForcesOn(body);
    if (schur_complement_ != nullptr)
      schur_complement_->AddCoupling(1, step.tail(slots), step.head(3 * n_));
    step.tail(slots) += columns_.col(0).tail(slots) - Slots(at_);
    const double length = result_.iterations == 0 ? 1 : Search(value_);
    at_ += length * step_;
    ++result_.iterations;
    value_ = potential_.Gradient(at_, &gradient_);
    result_.residual = Residual(contacts);
    result_.converged = length == 1 && result_.residual <= options_.tolerance;
    return result_.converged;
  }

  RelaxationResult End(const RelaxationResult& solved, Points* U) override {
    if (!iterates_) {
      *U = at_;
      Enter(*U);
      return solved;
    }
    result_.regularised = solved.regularised;
    result_.share_slope = potential_.ShareSlope();
    StopDamping();
    *U = at_;
    if (schur_complement_ != nullptr)
      schur_complement_->AddCoupling(-1, Slots(at_), Unknowns(U).head(3 * n_));
    if (!U->allFinite()) at_.setZero();  // the caller reports it; the next step starts at rest
    return result_;
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    at_rest_->SetActiveFunctions(active);
  }

  const LatticeCompliance* compliance() const override { return this; }

  // Uses the last Newton step's tangent.
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    if (!has_tangent_) {
      at_rest_->RespondTo(b, response);
      return;
    }
    FillUnitLoads(b, response);
    Respond(1, response);
  }

  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const override {
    if (has_tangent_) {
      Respond(1, loads);
    } else {
      at_rest_->SolveLoads(loads);
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
  static std::unique_ptr<ComplianceSolver> SolverAtRest(const RefinementBasis* functions, int slots,
                                                        const BlendedEnergy& energy,
                                                        const SchurComplement** schur_complement) {
    if (functions == nullptr) return MakeComplianceSolver(energy.stiffness_at_rest());
    auto refined = std::make_unique<EnrichedComplianceSolver>(*functions, slots);
    *schur_complement = &refined->schur_complement();
    return refined;
  }

  Eigen::VectorBlock<const ConstVectorMap> Slots(const Points& at) const {
    return {ConstVectorMap(at.data(), at.size()), 3 * n_, at.size() - 3 * n_};
  }

  // Sets (U_bar, V) from (U, V).
  void Enter(const Points& U) {
    at_ = U;
    if (schur_complement_ != nullptr)
      schur_complement_->AddCoupling(1, Slots(U), Unknowns(&at_).head(3 * n_));
  }

  // False if the iterations or the time are used up.
  bool BeginsIteration() {
    if (result_.iterations >= std::min(options_.max_iterations, input_.quality.newton_iterations))
      return false;
    result_.out_of_time = input_.stop_after > 0 ? result_.iterations == input_.stop_after
                                                : !TimeForAnother(result_.iterations);
    return !result_.out_of_time;
  }

  void StartDamping() {
    if (!(input_.damping > 0)) return;
    trial_ = at_;
    Enter(*input_.damped_from);
    U_bar_ = at_.topRows(n_);
    energy_.Damp(input_.damping, U_bar_);
    potential_.Damp(Slots(at_));
    at_ = trial_;
  }

  // The hand feels the elastic tangent without the damper, as with a quadratic energy.
  void StopDamping() {
    if (!(energy_.damping() > 0)) return;
    U_bar_ = at_.topRows(n_);
    energy_.Damp(0, U_bar_);
    has_tangent_ = has_tangent_ && factor_.Factorise(U_bar_, &energy_);
  }

  void StartWatch() {
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

  // Replaces columns of loads on (U, V) by the tangent's displacements (U, V). V moves by the share
  // `refinement_weight`.
  void Respond(double refinement_weight, Eigen::Ref<Eigen::MatrixXd> columns) const {
    auto lattice = columns.topRows(3 * n_);
    if (schur_complement_ != nullptr) {
      for (Eigen::Index c = 0; c < columns.cols(); ++c) {
        auto V = columns.col(c).tail(columns.rows() - 3 * n_);
        schur_complement_->Reduce(lattice.col(c), V);
        schur_complement_->Solve(V);
        V *= refinement_weight;
      }
    }
    factor_.SolveInPlace(lattice);
    if (schur_complement_ == nullptr) return;
    for (Eigen::Index c = 0; c < columns.cols(); ++c) {
      schur_complement_->AddCoupling(-1, columns.col(c).tail(columns.rows() - 3 * n_),
                                     lattice.col(c));
    }
  }

  Eigen::Ref<Eigen::MatrixXd> Responses(std::size_t sides) {
    return columns_.middleCols(1, static_cast<Eigen::Index>(sides));
  }

  // Computes the step from (U_bar, V) without contact forces and the responses to them.
  void RespondAtTangent(int body, const ContactConstraints& contacts, ContactSolver* solver) {
    const Eigen::Index slots = at_.size() - 3 * n_;
    auto free = columns_.col(0);
    free.head(3 * n_) = -Unknowns(&gradient_).head(3 * n_);
    Eigen::Index column = 1;
    for (const ContactSolver::Side& side : solver->sides(body)) {
      Eigen::Map<Points>(columns_.col(column++).data(), at_.rows(), 3).noalias() =
          contacts.Weights().row(side.row).transpose() * side.force_W.transpose();
    }
    Eigen::Ref<Eigen::MatrixXd> response = Responses(solver->sides(body).size());
    // A damper on V makes it yield less, starting at its position without load.
    const double kept = energy_.damping() / (1 + energy_.damping());
    factor_.SolveInPlace(free.head(3 * n_));
    free.tail(slots) = kept * potential_.damped_from();
    Respond(1 - kept, response);

    trial_.topRows(n_) = at_.topRows(n_) + Eigen::Map<const Points>(free.data(), n_, 3);
    Unknowns(&trial_).tail(slots) = free.tail(slots);
    if (schur_complement_ != nullptr) {
      schur_complement_->AddCoupling(-1, free.tail(slots), Unknowns(&trial_).head(3 * n_));
    }
    TakeOffChanges(body, contacts, trial_, solver);
    AddCompliance(body, contacts, response, 1 / (1 + energy_.damping()), solver);
  }

  double Search(double energy) {
    const double slope = gradient_.cwiseProduct(step_).sum();
    return SearchLength(at_, step_, energy, slope, 0, &potential_, &trial_, &load_);
  }

  // Returns the residual of U_bar; V is in equilibrium with its loads.
  double Residual(const ContactConstraints& contacts) {
    auto load = load_.topRows(n_);
    load.setZero();
    for (int i = 0; i < contacts.size(); ++i) {
      load.noalias() +=
          contacts.Weights().row(i).leftCols(n_).transpose() * contacts[i].force_W.transpose();
    }
    return (gradient_.topRows(n_) - load).norm() / std::max(load.norm(), least_load_);
  }

  BlendedEnergy energy_;
  NewtonOptions options_;
  Eigen::Index n_;
  const SchurComplement* schur_complement_ = nullptr;  // at_rest_'s
  Cloned<ComplianceSolver> at_rest_;                   // K^-1 of U = 0
  StepPotential potential_;
  NewtonFactor factor_;
  // (n + slots) x 3 each:
  Points at_;                 // m: U_bar and V where the last step ended
  Points trial_;              // m
  Points gradient_;           // N
  Points step_;               // m
  Points load_;               // N: B^T f
  Points U_bar_;              // n x 3
  WorkMatrix columns_;        // 3(n + slots) x (1 + equations): the free step, then the responses
  bool has_tangent_ = false;  // factor_ holds the last step's tangent
  double least_load_ = 0;     // N: least divisor of the residual
  RelaxationInput input_;     // of the present step
  bool iterates_ = false;     // the present step is not quadratic
  double value_ = 0;          // energy at at_, J
  RelaxationResult result_;   // of the present step
  Nanoseconds started_ = 0, iteration_began_ = 0, longest_ = 0;
};

}  // namespace

std::unique_ptr<Relaxation> MakeNewtonRelaxation(const ElasticEnergy& energy,
                                                 const NewtonOptions& options,
                                                 const RefinementBasis* functions, int slots) {
  return std::make_unique<NewtonRelaxation>(energy, options, functions, slots);
}

}  // namespace hpdm
