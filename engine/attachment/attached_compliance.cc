#include "engine/attachment/attached_compliance.h"

#include <algorithm>

namespace hpdm {

void AttachedCompliance::LoadModes(const SparseRow& b) const {
  work_.w.setZero();
  for (std::size_t i = 0; i < b.control_points.size(); ++i) {
    const int a = b.control_points[i];
    if (3 * a >= member_.unknowns()) break;
    work_.w += b.weights[i] * member_.response.middleRows<3>(3 * a).transpose();
  }
}

void AttachedCompliance::FindForces(Eigen::Ref<const Eigen::VectorXd> moved) const {
  work_.q.noalias() = state_.joint().stiffness() * moved;
  state_.Settle(work_.q);
  work_.settled = work_.q;
  state_.ForcesOf(work_.settled, &work_.q);
}

void AttachedCompliance::RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const {
  free_.RespondTo(b, response);
  LoadModes(b);
  for (int d = 0; d < 3; ++d) {
    FindForces(work_.w.col(d));
    work_.w.col(d) = work_.q;
  }
  // In blocks that stay in the cache for all three columns.
  constexpr Eigen::Index kBlock = 96;
  for (Eigen::Index at = 0; at < member_.unknowns(); at += kBlock) {
    const Eigen::Index rows = std::min(kBlock, member_.unknowns() - at);
    for (int d = 0; d < 3; ++d) {
      response.col(d).segment(at, rows).noalias() -=
          member_.response.middleRows(at, rows) * work_.w.col(d);
    }
  }
}

void AttachedCompliance::SolveLoads(Eigen::Ref<Eigen::MatrixXd> loads) const {
  for (Eigen::Index c = 0; c < loads.cols(); ++c) {
    auto moved = work_.w.col(0);
    moved.setZero();
    for (Eigen::Index i = 0; i < member_.unknowns(); ++i) {
      if (loads(i, c) != 0) moved += loads(i, c) * member_.response.row(i).transpose();
    }
    FindForces(moved);
    free_.SolveLoads(loads.col(c));
    loads.col(c).head(member_.unknowns()).noalias() -= member_.response * work_.q;
  }
}

Matrix3d AttachedCompliance::PointCompliance(const SparseRow& b) const {
  Matrix3d sum = free_.PointCompliance(b);
  LoadModes(b);
  for (int d = 0; d < 3; ++d) {
    FindForces(work_.w.col(d));
    sum.col(d) -= work_.w.transpose() * work_.q;
  }
  return (sum + sum.transpose()) / 2;
}

}  // namespace hpdm
