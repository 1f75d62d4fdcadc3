#include <utility>

#include "engine/base/copying.h"
#include "engine/solver/compliance_solver.h"
#include "engine/solver/contact_body.h"

namespace hpdm {
namespace {

// One solve with the factorised stiffness, then the contacts in their compliance space.
class CholeskyRelaxation final : public BodyRelaxation {
 public:
  /// `n`: control points and slots.
  CholeskyRelaxation(std::unique_ptr<ComplianceSolver> solver, Eigen::Index n)
      : solver_(std::move(solver)), U_(Points::Zero(n, 3)) {}
  std::unique_ptr<Relaxation> Clone() const override {
    return std::make_unique<CholeskyRelaxation>(*this);
  }
  void Take(const Relaxation& other) override {
    *this = static_cast<const CholeskyRelaxation&>(other);
  }

  bool IsQuadratic() const override { return true; }
  void Begin(const RelaxationInput& input, const ContactConstraints& contacts) override {
    SetActiveFunctions(contacts.refinement);
    input_ = input;
  }
  bool Linearise(int body, const ContactConstraints& contacts, ContactSolver* solver) override {
    LineariseQuadratic(body, contacts, input_, solver_.get(), solver);
    return true;
  }
  bool Advance(int body, const ContactConstraints&, const ContactSolver& solver) override {
    AdvanceQuadratic(body, input_, *solver_, solver, &U_);
    return true;
  }
  RelaxationResult End(const RelaxationResult& solved, Points* U) override {
    *U = U_;
    return solved;
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    solver_->SetActiveFunctions(active);
  }

  const LatticeCompliance* compliance() const override { return solver_.get(); }

 private:
  Cloned<ComplianceSolver> solver_;
  RelaxationInput input_;
  Points U_;  // n x 3, m
};

}  // namespace

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(K), K.rows());
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const RefinementBasis& functions, int slots) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(functions, slots),
                                              functions.inverse().rows() / 3 + slots);
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const FullStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(K), K.rows() / 3);
}

}  // namespace hpdm
