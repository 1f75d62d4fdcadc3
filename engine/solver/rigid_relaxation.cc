#include "engine/solver/contact_body.h"

namespace hpdm {
namespace {

// There are no control points, so K^-1 is zero between any two points.
class NoCompliance final : public LatticeCompliance {
 public:
  void RespondTo(const SparseRow&, Eigen::Ref<Eigen::MatrixXd>) const override {}
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd>) const override {}
  Matrix3d PointCompliance(const SparseRow&) const override { return Matrix3d::Zero(); }
};

class RigidRelaxation final : public BodyRelaxation {
 public:
  std::unique_ptr<Relaxation> Clone() const override {
    return std::make_unique<RigidRelaxation>(*this);
  }
  void Take(const Relaxation& other) override {
    *this = static_cast<const RigidRelaxation&>(other);
  }
  bool IsQuadratic() const override { return true; }
  void Begin(const RelaxationInput&, const ContactConstraints&) override {}
  bool Linearise(int, const ContactConstraints&, ContactSolver*) override { return true; }
  bool Advance(int, const ContactConstraints&, const ContactSolver&) override { return true; }
  RelaxationResult End(const RelaxationResult& solved, Points*) override { return solved; }
  const LatticeCompliance* compliance() const override { return &nothing_; }

 private:
  NoCompliance nothing_;
};

}  // namespace

std::unique_ptr<Relaxation> MakeRigidRelaxation() { return std::make_unique<RigidRelaxation>(); }

}  // namespace hpdm
