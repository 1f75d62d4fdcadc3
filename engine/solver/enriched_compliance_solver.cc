#include "engine/solver/enriched_compliance_solver.h"

#include <array>

#include "engine/solver/unit_responses.h"

namespace hpdm {

EnrichedComplianceSolver::EnrichedComplianceSolver(const RefinementBasis& functions, int slots)
    : schur_complement_(functions, slots),
      unknowns_(functions.inverse().rows()),
      rows_(functions.inverse()),
      local_loads_(3 * slots, 3 * kMaxContacts),
      local_response_(3 * slots, 3 * kMaxContacts),
      V_(3 * slots),
      scratch_(unknowns_) {}

void EnrichedComplianceSolver::Respond(int body, const ContactConstraints& contacts, double yield,
                                       ContactSolver* contact_solver) {
  SetActiveFunctions(contacts.refinement);
  rows_.Gather(contacts);
  rows_.AddCompliance(body, yield, contact_solver);
  const Eigen::Index slots = V_.size() / 3, n = unknowns_ / 3;
  for (int i = 0; i < contacts.size(); ++i) {
    auto loads = local_loads_.middleCols<3>(3 * i);
    for (Eigen::Index s = 0; s < slots; ++s) {
      loads.middleRows<3>(3 * s) = contacts.Weights()(i, n + s) * Matrix3d::Identity();
    }
    for (const RowResponses::Entry& entry : rows_.EntriesOf(i)) {
      schur_complement_.ReducePoint(entry.point, entry.weight, loads);
    }
    auto response = local_response_.middleCols<3>(3 * i);
    response = loads;
    for (int d = 0; d < 3; ++d) schur_complement_.Solve(response.col(d));
  }
  for (const ContactSolver::Side& loaded : contact_solver->sides(body)) {
    V_.noalias() = local_response_.middleCols<3>(3 * loaded.row) * loaded.force_W;
    Vector3d moved = Vector3d::Zero();
    int at = -1;  // the sides of one row follow each other
    for (const ContactSolver::Side& side : contact_solver->sides(body)) {
      if (side.row != at) {
        at = side.row;
        moved.noalias() = local_loads_.middleCols<3>(3 * at).transpose() * V_;
      }
      contact_solver->AddCompliance(side.equation, loaded.equation, side.axis_W.dot(moved), yield);
    }
  }
}

void EnrichedComplianceSolver::Deform(int body, const ContactSolver& contact_solver,
                                      Points* U) const {
  rows_.SetForces(body, contact_solver);
  Eigen::Map<Eigen::VectorXd> u(U->data(), U->size());
  auto lattice = u.head(unknowns_);
  rows_.Deform(lattice);
  V_.setZero();
  for (const ContactSolver::Side& side : contact_solver.sides(body)) {
    const Vector3d force = contact_solver.forces()[side.equation] * side.force_W;
    V_.noalias() += local_response_.middleCols<3>(3 * side.row) * force;
  }
  schur_complement_.AddCoupling(-1, V_, lattice);
  u.tail(V_.size()) = V_;
}

void EnrichedComplianceSolver::SolveLoads(Eigen::Ref<Eigen::MatrixXd> columns) const {
  for (Eigen::Index c = 0; c < columns.cols(); ++c) SolveColumn(columns.col(c));
}

void EnrichedComplianceSolver::RespondToSet(std::span<const SparseRow> rows,
                                            Eigen::Ref<Eigen::MatrixXd> responses) const {
  auto lattice = responses.topRows(unknowns_);
  auto local = responses.bottomRows(responses.rows() - unknowns_);
  FillUnitResponses(schur_complement_.functions().inverse(), rows, lattice);
  local.setZero();
  const auto n = static_cast<int>(unknowns_ / 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto loads = local.middleCols<3>(3 * static_cast<Eigen::Index>(i));
    for (std::size_t k = 0; k < rows[i].control_points.size(); ++k) {
      const int point = rows[i].control_points[k];
      const double weight = rows[i].weights[k];
      if (point < n) {
        schur_complement_.ReducePoint(point, weight, loads);
      } else {
        loads.middleRows<3>(3 * (point - n)).diagonal().array() += weight;
      }
    }
  }
  for (Eigen::Index c = 0; c < responses.cols(); ++c) {
    schur_complement_.Solve(local.col(c));
    schur_complement_.AddCoupling(-1, local.col(c), lattice.col(c));
  }
}

// Skips the zeros of the load: a contact's row has one entry for each non-zero function. Takes four
// columns at a time, which adds them in the same order with fewer passes over the sum.
void EnrichedComplianceSolver::SolveColumn(Eigen::Ref<Eigen::VectorXd> column) const {
  auto f = column.head(unknowns_);
  auto g = column.tail(column.size() - unknowns_);
  const Eigen::MatrixXd& inverse = schur_complement_.functions().inverse();
  scratch_.setZero();
  std::array<Eigen::Index, 4> at;
  std::size_t count = 0;
  for (Eigen::Index i = 0; i < unknowns_; ++i) {
    if (f[i] == 0) continue;
    at[count++] = i;
    if (count < at.size()) continue;
    scratch_ = scratch_ + f[at[0]] * inverse.col(at[0]) + f[at[1]] * inverse.col(at[1]) +
               f[at[2]] * inverse.col(at[2]) + f[at[3]] * inverse.col(at[3]);
    count = 0;
  }
  for (std::size_t k = 0; k < count; ++k) scratch_ += f[at[k]] * inverse.col(at[k]);
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
