#include "engine/solver/enriched_compliance_solver.h"

namespace hpdm {

EnrichedComplianceSolver::EnrichedComplianceSolver(const RefinementBasis& functions, int slots)
    : schur_complement_(functions, slots),
      unknowns_(functions.inverse().rows()),
      response_(unknowns_ + 3 * slots, ContactSolver::kMaxEquations),
      scratch_(unknowns_) {}

void EnrichedComplianceSolver::Respond(int body, const ContactConstraints& contacts, double yield,
                                       ContactSolver* contact_solver) {
  SetActiveFunctions(contacts.refinement);
  Eigen::Index columns = 0;
  for (const ContactSolver::Side& side : contact_solver->sides(body)) {
    auto load = response_.col(columns++);
    for (Eigen::Index a = 0; 3 * a < load.size(); ++a) {
      load.segment<3>(3 * a) = contacts.Weights()(side.row, a) * side.force_W;
    }
  }
  SolveLoads(response_.leftCols(columns));
  AddCompliance(body, contacts, response_, yield, contact_solver);
}

void EnrichedComplianceSolver::Deform(int body, const ContactSolver& contact_solver,
                                      Points* U) const {
  Eigen::Map<Eigen::VectorXd>(U->data(), U->size()).noalias() =
      response_.leftCols(static_cast<Eigen::Index>(contact_solver.sides(body).size())) *
      contact_solver.ForcesOn(body);
}

void EnrichedComplianceSolver::SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) SolveColumn(columns.col(c));
}

void EnrichedComplianceSolver::RespondTo(const SparseRow& b,
                                         Eigen::Ref<Eigen::MatrixXd> response) const {
  FillUnitLoads(b, response);
  SolveLoads(response);
}

// Skips the zeros of the load: a contact's row has one entry for each non-zero function.
void EnrichedComplianceSolver::SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const {
  auto f = column.head(unknowns_);
  auto g = column.tail(column.size() - unknowns_);
  const Eigen::MatrixXd& inverse = schur_complement_.functions().inverse();
  scratch_.setZero();
  for (Eigen::Index i = 0; i < unknowns_; ++i) {
    if (f[i] != 0) scratch_ += f[i] * inverse.col(i);
  }
  schur_complement_.Reduce(f, g);
  schur_complement_.Solve(g);
  f = scratch_;
  schur_complement_.AddCoupling(-1, g, f);
}

std::unique_ptr<ComplianceSolver> MakeComplianceSolver(const RefinementBasis& functions,
                                                       int slots) {
  return std::make_unique<EnrichedComplianceSolver>(functions, slots);
}

}  // namespace hpdm
