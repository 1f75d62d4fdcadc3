#include "engine/baselines/contact_forces.h"

namespace hpdm {

ContactRows::ContactRows(Eigen::Index n)
    : entries_(static_cast<std::size_t>(n) * static_cast<std::size_t>(kMaxContacts)) {}

void ContactRows::Gather(const ContactConstraints& contacts) {
  size_ = contacts.size();
  std::size_t next = 0;
  for (int i = 0; i < size_; ++i) {
    first_[i] = next;
    const auto weights = contacts.Weights().row(i);
    for (Eigen::Index v = 0; v < weights.size(); ++v) {
      if (weights[v] != 0) entries_[next++] = {static_cast<int>(v), weights[v]};
    }
  }
  first_[size_] = next;
}

Vector3d ContactRows::Sum(int row, const Points& values) const {
  Vector3d sum = Vector3d::Zero();
  for (const Entry* e = begin(row); e != end(row); ++e) {
    sum += e->weight * values.row(e->vertex).transpose();
  }
  return sum;
}

RelaxationResult SolveContactForces(const ContactCompliance& compliance,
                                    const ContactPoints& p_free_W, const ContactPoints& targets_W,
                                    ContactSolver* contact_solver, ContactConstraints* contacts) {
  contact_solver->Build(*contacts);
  for (const ContactSolver::Side& a : contact_solver->sides()) {
    contact_solver->change()[a.equation] = a.axis_W.dot(targets_W[a.row] - p_free_W[a.row]);
    for (const ContactSolver::Side& b : contact_solver->sides()) {
      contact_solver->compliance()(a.equation, b.equation) =
          compliance(a.row, b.row) * a.axis_W.dot(b.axis_W);
    }
  }
  const RelaxationResult result = contact_solver->Solve();
  contact_solver->WriteForces(contacts);
  return result;
}

}  // namespace hpdm
