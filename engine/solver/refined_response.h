#pragma once

#include "engine/solver/lattice_response.h"
#include "engine/solver/local_response.h"

namespace hpdm {

/// A lattice of constant stiffness with local functions in use: with a load (f, g) on the control
/// points and on them (local_response.h),
///     V = Sigma^-1 (g - Y^T f),   U = K^-1 f - Y V.
class RefinedResponse final : public LatticeResponse {
 public:
  RefinedResponse(const LocalFunctions& functions, int slots);

  void Follow(const ActiveFunctions& active) override { local_.Follow(active); }
  const LocalResponse& local() const { return local_; }

  void Respond(const ContactSet& contacts, ContactProblem* problem) override;
  void Deform(const ContactProblem& problem, Points* U) const override;
  void Solve(Eigen::Ref<Eigen::MatrixXd> columns) const override;
  void RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const override;
  Matrix3d PointCompliance(const SparseRow& b) const override {
    return PointBlock(local_.functions().inverse(), b);
  }

 private:
  void SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const;

  LocalResponse local_;
  Eigen::Index unknowns_;            // 3n
  Eigen::MatrixXd response_;         // (3n + 3 slots) x kMaxEquations
  mutable Eigen::VectorXd scratch_;  // 3n
};

}  // namespace hpdm
