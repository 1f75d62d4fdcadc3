#include "engine/contact/contact_solver.h"
#include "engine/solver/relaxation.h"

namespace hpdm {
namespace {

// There are no control points, so K^-1 is zero between any two points.
class NoCompliance final : public LatticeCompliance {
 public:
  void RespondTo(const SparseRow&, Eigen::Ref<Eigen::MatrixXd>) const override {}
  Matrix3d PointCompliance(const SparseRow&) const override { return Matrix3d::Zero(); }
};

class RigidRelaxation final : public Relaxation {
 public:
  RelaxationResult DoRelax(const RelaxationInput& /*input*/, ContactConstraints* contacts,
                           Points* /*U*/) override {
    if (contacts->size() == 0) return {};
    contact_solver_.Build(*contacts);
    contact_solver_.compliance().setZero();
    const RelaxationResult result = contact_solver_.Solve();
    contact_solver_.WriteForces(contacts);
    return result;
  }
  const LatticeCompliance* compliance() const override { return &nothing_; }

 private:
  NoCompliance nothing_;
  ContactSolver contact_solver_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeRigidRelaxation() { return std::make_unique<RigidRelaxation>(); }

}  // namespace hpdm
