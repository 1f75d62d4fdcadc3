#include <utility>

#include "engine/solver/lattice_response.h"
#include "engine/solver/relaxation.h"

namespace hpdm {
namespace {

// One solve with the factorised stiffness, then the contacts in their compliance space.
class CholeskyRelaxation final : public Relaxation {
 public:
  explicit CholeskyRelaxation(std::unique_ptr<LatticeResponse> response)
      : response_(std::move(response)) {}

  RelaxationResult Relax(ContactSet* contacts, Points* U) override {
    Follow(contacts->local);
    if (contacts->size() == 0) {
      U->setZero();
      return {};
    }
    return SolveContacts(response_.get(), &problem_, contacts, U);
  }

  void Follow(const ActiveFunctions& active) override { response_->Follow(active); }

  const LatticeCompliance* compliance() const override { return response_.get(); }

 private:
  std::unique_ptr<LatticeResponse> response_;
  ContactProblem problem_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const ScalarStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeLatticeResponse(K));
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const LocalFunctions& functions, int slots) {
  return std::make_unique<CholeskyRelaxation>(MakeLatticeResponse(functions, slots));
}

std::unique_ptr<Relaxation> MakeCholeskyRelaxation(const FullStiffness& K) {
  return std::make_unique<CholeskyRelaxation>(MakeLatticeResponse(K));
}

}  // namespace hpdm
