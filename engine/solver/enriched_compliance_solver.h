#pragma once

#include "engine/solver/compliance_solver.h"
#include "engine/solver/schur_complement.h"

namespace hpdm {

/// A lattice of constant stiffness with local functions in use. With the loads f on the control
/// points and g on the local functions (schur_complement.h),
///     V = Sigma^-1 (g - Y^T f),   U = K^-1 f - Y V.
class EnrichedComplianceSolver final : public ComplianceSolver {
 public:
  EnrichedComplianceSolver(const RefinementBasis& functions, int slots);

  void SetActiveFunctions(const ActiveRefinement& active) override {
    schur_complement_.SetActiveFunctions(active);
  }
  const SchurComplement& schur_complement() const { return schur_complement_; }

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override;
  void Deform(int body, const ContactSolver& contact_solver, Points* U) const override;
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const override;
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override;
  Matrix3d PointCompliance(const SparseRow& b) const override {
    return PointBlock(schur_complement_.functions().inverse(), b);
  }

 private:
  void SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const;

  SchurComplement schur_complement_;
  Eigen::Index unknowns_;            // 3n
  Eigen::MatrixXd response_;         // (3n + 3 slots) x kMaxEquations
  mutable Eigen::VectorXd scratch_;  // 3n
};

}  // namespace hpdm
