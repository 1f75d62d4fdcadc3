#include "engine/baselines/contact_forces.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace hpdm {

ContactRows::ContactRows(Eigen::Index n)
    : entries_(static_cast<std::size_t>(n) * static_cast<std::size_t>(kMaxContacts)) {}

void ContactRows::Gather(const ContactSet& contacts) {
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

ContactForces::Outcome ContactForces::Solve(const ContactCompliance& compliance,
                                            const ContactPoints& p_free_W,
                                            const ContactPoints& targets_W, ContactSet* contacts) {
  Outcome outcome;
  scale_ = 0;
  for (int i = 0; i < contacts->size(); ++i) {
    const ContactSet::Row& row = (*contacts)[i];
    const Vector3d change = targets_W[i] - p_free_W[i];
    scale_ = std::max(scale_, change.norm());
    pushes_[i] = row.kind == ContactSet::RowKind::kGrasp || row.normal_W.dot(change) < 0;
  }
  // Active-set method. A press is let go when it would pull and taken on when its plane would be
  // pierced; the bound ends a cycle.
  constexpr int kMaxRounds = 2 * kMaxContacts;
  bool changed = true;
  while (changed && outcome.rounds < kMaxRounds) {
    ++outcome.rounds;
    outcome.regularised = SolvePushing(compliance, p_free_W, targets_W, contacts);
    changed = UpdatePushing(compliance, p_free_W, targets_W, *contacts);
  }
  outcome.converged = !changed;
  return outcome;
}

void ContactForces::AddEquation(int row, const Vector3d& axis) {
  row_[equations_] = row;
  axis_[equations_++] = axis;
}

bool ContactForces::SolvePushing(const ContactCompliance& compliance, const ContactPoints& p_free_W,
                                 const ContactPoints& targets_W, ContactSet* contacts) {
  equations_ = 0;
  for (int i = 0; i < contacts->size(); ++i) {
    ContactSet::Row& row = (*contacts)[i];
    row.force_W.setZero();
    if (!pushes_[i]) continue;
    if (row.kind == ContactSet::RowKind::kPress) {
      AddEquation(i, row.normal_W);
    } else {
      for (int d = 0; d < 3; ++d) AddEquation(i, Vector3d::Unit(d));
    }
  }
  if (equations_ == 0) return false;

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxEquations,
                kMaxEquations>
      matrix(equations_, equations_);
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxEquations, 1> force(equations_);
  for (int e = 0; e < equations_; ++e) {
    for (int g = 0; g < equations_; ++g) {
      matrix(e, g) = compliance(row_[e], row_[g]) * axis_[e].dot(axis_[g]);
    }
    force[e] = axis_[e].dot(targets_W[row_[e]] - p_free_W[row_[e]]);
  }
  // A compliance of 1e-9 of the softest contact in series with each lets coincident contacts share
  // their force and moves the others by one part in 1e9.
  const double pad = 1e-9 * matrix.diagonal().maxCoeff();
  matrix.diagonal().array() += pad;
  const Eigen::LDLT<decltype(matrix)> factor(matrix);
  force = factor.solve(force).eval();
  for (int e = 0; e < equations_; ++e) (*contacts)[row_[e]].force_W += force[e] * axis_[e];
  return factor.vectorD().minCoeff() < 10 * pad;
}

bool ContactForces::UpdatePushing(const ContactCompliance& compliance,
                                  const ContactPoints& p_free_W, const ContactPoints& targets_W,
                                  const ContactSet& contacts) {
  bool changed = false;
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactSet::Row& row = contacts[i];
    if (row.kind == ContactSet::RowKind::kGrasp) continue;
    bool pushes = row.normal_W.dot(row.force_W) < 0;
    if (!pushes_[i]) {
      Vector3d p = p_free_W[i];
      for (int j = 0; j < contacts.size(); ++j) p += compliance(i, j) * contacts[j].force_W;
      // Round-off of the solve is below 1e-9 of what the contacts ask for.
      pushes = row.normal_W.dot(p - targets_W[i]) > 1e-9 * scale_;
    }
    changed = changed || pushes != pushes_[i];
    pushes_[i] = pushes;
  }
  return changed;
}

}  // namespace hpdm
