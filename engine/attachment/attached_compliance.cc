#include "engine/attachment/attached_compliance.h"

#include <algorithm>

namespace hpdm {

void AttachedCompliance::Work::MakeRoom(const AttachmentJoint& joint, Eigen::Index columns) {
  const Eigen::Index unknowns = std::max(w_0.rows(), 3 * joint.modes());
  w_0.resize(unknowns, std::max(w_0.cols(), columns));
  half.resize(std::max(half.rows(), JointSolver::MostHalfSize(joint)), w_0.cols());
  half_forces = half;
  few_w.resize(unknowns, kFewColumns);
  few_q.resize(static_cast<std::size_t>(FullGroups(w_0.cols()) / kFewColumns), few_w);
  for (FewColumns& q : few_q) q.resize(unknowns, kFewColumns);
  moved.resize(kRowsTogether, kFewColumns);
}

void AttachedCompliance::LoadModes(int i, const SparseRow& b) const {
  auto w_0 = work_.w_0.block(0, 3 * i, unknowns_, 3);
  w_0.setZero();
  for (std::size_t k = 0; k < b.control_points.size(); ++k) {
    const int a = b.control_points[k];
    if (3 * a >= member_.unknowns()) break;
    const auto response = member_.response.middleRows<3>(3 * a);
    if (turned_) {
      const Matrix3d turned = b.weights[k] * R_WF_.transpose();
      w_0 += response.transpose().lazyProduct(turned);
      continue;
    }
    for (int d = 0; d < 3; ++d) w_0.col(d) += b.weights[k] * response.row(d).transpose();
  }
}

void AttachedCompliance::FindForces(Eigen::Index group) const {
  state_.solver().FindForces(work_.few_w.topRows(unknowns_),
                             work_.few_q[static_cast<std::size_t>(group)].topRows(unknowns_));
}

// Passes once through the member's response, which is larger than the caches.
void AttachedCompliance::TakeLayers(Eigen::Ref<Eigen::MatrixXd> responses) const {
  for (Eigen::Index first = 0; first < member_.unknowns(); first += kRowsTogether) {
    const Eigen::Index rows = std::min(kRowsTogether, member_.unknowns() - first);
    auto moved = work_.moved.topRows(rows);
    for (Eigen::Index c = 0; c < responses.cols(); ++c) {
      const Eigen::Index in_group = c % kFewColumns;
      if (in_group == 0) {
        const FewColumns& q = work_.few_q[static_cast<std::size_t>(c / kFewColumns)];
        Multiply(member_.response.middleRows(first, rows), q.topRows(unknowns_), moved);
      }
      auto response = responses.col(c).segment(first, rows);
      if (!turned_) {
        response -= moved.col(in_group);
        continue;
      }
      for (Eigen::Index i = 0; i < rows; i += 3) {
        response.segment<3>(i) -= R_WF_ * moved.col(in_group).segment<3>(i);
      }
    }
  }
}

void AttachedCompliance::RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const {
  RespondInPart({&b, 1}, response);
  const Matrix3d unit_forces = Matrix3d::Identity();
  AddOtherPart(unit_forces, response);
}

void AttachedCompliance::RespondInPart(std::span<const SparseRow> rows,
                                       Eigen::Ref<Eigen::MatrixXd> responses) const {
  free_.RespondToSet(rows, responses);
  for (std::size_t i = 0; i < rows.size(); ++i) LoadModes(static_cast<int>(i), rows[i]);
}

void AttachedCompliance::AddOtherPart(Eigen::Ref<Eigen::MatrixXd> compliance) const {
  const Eigen::Index count = compliance.cols();
  auto half = work_.half.topLeftCorner(state_.solver().half_size(), count);
  auto half_forces = work_.half_forces.topLeftCorner(half.rows(), count);
  state_.solver().Halve(work_.w_0.topLeftCorner(unknowns_, count), half);
  half_forces = half;
  state_.solver().TakeDuctForces(half_forces);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (Eigen::Index i = 0; i <= j; ++i) {
      const double held = half.col(i).dot(half_forces.col(j));
      compliance(i, j) -= held;
      if (i != j) compliance(j, i) -= held;
    }
  }
}

void AttachedCompliance::AddOtherPart(const Eigen::Ref<const Eigen::MatrixXd>& forces,
                                      Eigen::Ref<Eigen::MatrixXd> responses) const {
  for (Eigen::Index first = 0; first < responses.cols(); first += kFewColumns) {
    const Eigen::Index count = std::min<Eigen::Index>(kFewColumns, responses.cols() - first);
    auto w_0 = work_.few_w.topRows(unknowns_);
    w_0.setZero();
    for (Eigen::Index c = 0; c < count; ++c) {
      auto sum = work_.half.col(0).head(unknowns_);
      sum.noalias() = work_.w_0.topLeftCorner(unknowns_, forces.rows()) * forces.col(first + c);
      w_0.col(c) = sum;
    }
    FindForces(first / kFewColumns);
  }
  TakeLayers(responses);
}

void AttachedCompliance::SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const {
  const auto at_once = static_cast<Eigen::Index>(work_.few_q.size()) * kFewColumns;
  for (Eigen::Index first = 0; first < loads.cols(); first += at_once) {
    auto some = loads.middleCols(first, std::min(at_once, loads.cols() - first));
    for (Eigen::Index c = 0; c < some.cols(); c += kFewColumns) {
      LoadModes(some.middleCols(c, std::min<Eigen::Index>(kFewColumns, some.cols() - c)));
      FindForces(c / kFewColumns);
    }
    free_.SolveLoads(some);
    TakeLayers(some);
  }
}

void AttachedCompliance::LoadModes(const Eigen::Ref<const Eigen::MatrixXd>& loads) const {
  work_.few_w.setZero();
  for (Eigen::Index c = 0; c < loads.cols(); ++c) {
    const auto load = loads.col(c);
    auto w_0 = work_.half.col(0).head(unknowns_);
    w_0.setZero();
    for (Eigen::Index i = 0; i < member_.unknowns(); ++i) {
      const double along = turned_ ? R_WF_.col(i % 3).dot(load.segment<3>(i - i % 3)) : load[i];
      if (along != 0) w_0 += along * member_.response.row(i).transpose();
    }
    work_.few_w.col(c).head(unknowns_) = w_0;
  }
}

Matrix3d AttachedCompliance::PointCompliance(const SparseRow& b) const {
  Matrix3d sum = free_.PointCompliance(b);
  LoadModes(0, b);
  Eigen::Matrix3d both = (sum + sum.transpose()) / 2;
  AddOtherPart(Eigen::Ref<Eigen::MatrixXd>(both));
  return both;
}

}  // namespace hpdm
