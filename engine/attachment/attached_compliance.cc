#include "engine/attachment/attached_compliance.h"

namespace hpdm {

void AttachedCompliance::LoadModes(int i, const SparseRow& b) const {
  auto half_tied = work_.half_tied.block(0, 3 * i, unknowns_, 3);
  auto tied = work_.tied.block(0, 3 * i, unknowns_, 3);
  half_tied.setZero();
  tied.setZero();
  for (std::size_t k = 0; k < b.control_points.size(); ++k) {
    const int a = b.control_points[k];
    if (3 * a >= member_.unknowns()) break;
    if (turned_) {
      const Matrix3d turned = b.weights[k] * R_WF_.transpose();
      half_tied += member_.half_tied.middleRows<3>(3 * a).transpose().lazyProduct(turned);
      tied += member_.tied.middleRows<3>(3 * a).transpose().lazyProduct(turned);
      continue;
    }
    half_tied += b.weights[k] * member_.half_tied.middleRows<3>(3 * a).transpose();
    tied += b.weights[k] * member_.tied.middleRows<3>(3 * a).transpose();
  }
}

void AttachedCompliance::TakeLayers(Eigen::Ref<Eigen::VectorXd> response) const {
  auto w = work_.w.head(unknowns_);
  state_.Settle(w);
  state_.ForcesOf(w, work_.q.head(unknowns_));
  const auto q = work_.q.head(unknowns_);
  if (!turned_) {
    response.head(member_.unknowns()).noalias() -= member_.response * q;
    return;
  }
  for (Eigen::Index i = 0; i < member_.unknowns(); i += 3) {
    const Vector3d moved_F = member_.response.middleRows<3>(i) * q;
    response.segment<3>(i) -= R_WF_ * moved_F;
  }
}

void AttachedCompliance::RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const {
  RespondInPart(0, b, response);
  const Matrix3d unit_forces = Matrix3d::Identity();
  AddOtherPart(unit_forces, response);
}

void AttachedCompliance::RespondInPart(int i, const SparseRow& b,
                                       Eigen::Ref<Eigen::MatrixXd> response) const {
  free_.RespondTo(b, response);
  LoadModes(i, b);
}

void AttachedCompliance::AddOtherPart(Eigen::Ref<Eigen::MatrixXd> compliance) const {
  const Eigen::Index count = compliance.cols();
  const auto half_tied = work_.half_tied.topLeftCorner(unknowns_, count);
  const auto tied = work_.tied.topLeftCorner(unknowns_, count);
  auto half = work_.half.topLeftCorner(unknowns_, count);
  half = tied;
  state_.HalfSettle(half, &work_.few);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (Eigen::Index i = 0; i <= j; ++i) {
      const double held = half_tied.col(i).dot(half_tied.col(j)) - half.col(i).dot(half.col(j));
      compliance(i, j) -= held;
      if (i != j) compliance(j, i) -= held;
    }
  }
}

void AttachedCompliance::AddOtherPart(const Eigen::Ref<const Eigen::MatrixXd>& forces,
                                      Eigen::Ref<Eigen::MatrixXd> responses) const {
  for (Eigen::Index c = 0; c < responses.cols(); ++c) {
    work_.w.setZero();
    for (Eigen::Index k = 0; k < forces.rows(); ++k) {
      work_.w.head(unknowns_) += forces(k, c) * work_.tied.col(k).head(unknowns_);
    }
    TakeLayers(responses.col(c));
  }
}

void AttachedCompliance::SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const {
  for (Eigen::Index c = 0; c < loads.cols(); ++c) {
    auto load = loads.col(c);
    work_.w.setZero();
    for (Eigen::Index i = 0; i < member_.unknowns(); ++i) {
      const double along = turned_ ? R_WF_.col(i % 3).dot(load.segment<3>(i - i % 3)) : load[i];
      if (along != 0) work_.w.head(unknowns_) += along * member_.tied.row(i).transpose();
    }
    free_.SolveLoads(load);
    TakeLayers(load);
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
