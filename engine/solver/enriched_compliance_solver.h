#pragma once

#include <memory>

#include "engine/base/copying.h"
#include "engine/solver/compliance_solver.h"
#include "engine/solver/row_responses.h"
#include "engine/solver/schur_complement.h"

namespace hpdm {

/// A lattice of constant stiffness with local functions in use. With the loads f on the control
/// points and g on the local functions (schur_complement.h),
///     V = Sigma^-1 (g - Y^T f),   U = K^-1 f - Y V,
/// so with the rows B = [B_U B_V] the compliance of contacts is
///     B_U K^-1 B_U^T + Z^T Sigma^-1 Z,   Z = B_V^T - Y^T B_U^T.
class EnrichedComplianceSolver final : public ComplianceSolver {
 public:
  EnrichedComplianceSolver(const RefinementBasis& functions, int slots);
  std::unique_ptr<ComplianceSolver> Clone() const override {
    return std::make_unique<EnrichedComplianceSolver>(*this);
  }
  void Take(const ComplianceSolver& other) override {
    *this = static_cast<const EnrichedComplianceSolver&>(other);
  }

  void SetActiveFunctions(const ActiveRefinement& active) override {
    schur_complement_.SetActiveFunctions(active);
  }
  const SchurComplement& schur_complement() const { return schur_complement_; }

  void Respond(int body, const ContactConstraints& contacts, double yield,
               ContactSolver* contact_solver) override;
  void Deform(int body, const ContactSolver& contact_solver, Points* U) const override;
  void SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const override;
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override {
    RespondToSet({&b, 1}, response);
  }
  void RespondToSet(std::span<const SparseRow> rows,
                    Eigen::Ref<Eigen::MatrixXd> responses) const override;
  void AddLocalPart(const Eigen::Ref<const Eigen::VectorXd>& V,
                    Eigen::Ref<Eigen::VectorXd> U_bar) const override {
    schur_complement_.AddCoupling(1, V, U_bar);
  }
  Matrix3d PointCompliance(const SparseRow& b) const override {
    return PointBlock(schur_complement_.functions().inverse(), b);
  }

 private:
  void SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const;

  SchurComplement schur_complement_;
  Eigen::Index unknowns_;  // 3n
  mutable RowResponses rows_;
  WorkMatrix local_loads_;           // 3 slots x 3 kMaxContacts: Z
  WorkMatrix local_response_;        // the same: Sigma^-1 Z
  mutable Eigen::VectorXd V_;        // 3 slots
  mutable Eigen::VectorXd scratch_;  // 3n
};

}  // namespace hpdm
