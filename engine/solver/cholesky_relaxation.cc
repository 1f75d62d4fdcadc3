#include <utility>

#include "engine/solver/compliance_solver.h"
#include "engine/solver/relaxation.h"

namespace hpdm {
namespace {

// One solve with the factorised stiffness, then the contacts in their compliance space.
class CholeskyRelaxation final : public Relaxation {
 public:
  explicit CholeskyRelaxation(std::unique_ptr<ComplianceSolver> solver)
      : solver_(std::move(solver)) {}

  RelaxationResult DoRelax(const RelaxationInput& /*input*/, ContactConstraints* contacts,
                           Points* U) override {
    SetActiveFunctions(contacts->refinement);
    if (contacts->size() == 0) {
      U->setZero();
      return {};
    }
    return SolveContacts(solver_.get(), &contact_solver_, contacts, U);
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    solver_->SetActiveFunctions(active);
  }

  const LatticeCompliance* compliance() const override { return solver_.get(); }

 private:
  std::unique_ptr<ComplianceSolver> solver_;
  ContactSolver contact_solver_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(K));
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const RefinementBasis& functions, int slots) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(functions, slots));
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const FullStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeComplianceSolver(K));
}

}  // namespace hpdm
