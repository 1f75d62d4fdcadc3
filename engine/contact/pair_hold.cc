#include "engine/contact/pair_hold.h"

#include <Eigen/LU>
#include <array>

namespace hpdm {
namespace {

constexpr int kMost = ContactSolver::kMaxEquations;
using HeldMatrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMost, kMost>;
using HeldColumns = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::ColMajor, kMost, 3>;

}  // namespace

PairHold::PairHold()
    : sides_(2 * kMost),
      first_side_(ContactSolver::kMaxBodies + 1),
      compliance_(kMost, kMost),
      stiffness_(kMost, kMost) {}

void PairHold::Take(const ContactSolver& solver) {
  size_ = 0;
  std::array<int, kMost> place;
  std::array<int, kMost> held;
  for (int e = solver.first_pair_equation(); e < solver.size(); ++e) {
    place[static_cast<std::size_t>(e)] = solver.IsActive(e) ? size_ : -1;
    if (solver.IsActive(e)) held[static_cast<std::size_t>(size_++)] = e;
  }
  if (size_ == 0) return;
  for (int i = 0; i < size_; ++i) {
    for (int j = 0; j < size_; ++j) {
      compliance_(i, j) =
          solver.WithFriction(held[static_cast<std::size_t>(i)], held[static_cast<std::size_t>(j)]);
    }
  }
  auto A = compliance_.topLeftCorner(size_, size_);
  A.diagonal().array() += 1e-9 * A.diagonal().maxCoeff();  // as in ContactSolver
  Eigen::Ref<HeldMatrix> matrix(A);
  const Eigen::PartialPivLU<Eigen::Ref<HeldMatrix>> factor(matrix);
  auto inverse = stiffness_.topLeftCorner(size_, size_);
  inverse.setIdentity();
  inverse = factor.permutationP() * inverse;
  factor.matrixLU().triangularView<Eigen::UnitLower>().solveInPlace(inverse);
  factor.matrixLU().triangularView<Eigen::Upper>().solveInPlace(inverse);

  std::size_t count = 0;
  for (int body = 0; body < solver.bodies(); ++body) {
    first_side_[static_cast<std::size_t>(body)] = count;
    for (const ContactSolver::Side& side : solver.sides(body)) {
      if (side.equation < solver.first_pair_equation()) continue;
      const int at = place[static_cast<std::size_t>(side.equation)];
      if (at < 0) continue;
      sides_[count++] = {at, side.row, side.axis_W, solver.ForceWithFriction(side)};
    }
  }
  first_side_[static_cast<std::size_t>(solver.bodies())] = count;
}

std::span<const PairHold::Side> PairHold::sides(int body) const {
  if (size_ == 0) return {};
  const auto b = static_cast<std::size_t>(body);
  return {sides_.data() + first_side_[b], first_side_[b + 1] - first_side_[b]};
}

HeldCompliance::HeldCompliance(const LatticeCompliance& free, const ContactConstraints& contacts,
                               const PairHold& hold, int body, Eigen::MatrixXd* scratch)
    : free_(free), contacts_(contacts), hold_(hold), body_(body), scratch_(scratch) {
  const auto weights = contacts.Weights();
  const std::span<const PairHold::Side> sides = hold.sides(body);
  auto loads = scratch_->topLeftCorner(3 * weights.cols(), static_cast<Eigen::Index>(sides.size()));
  loads.setZero();
  for (std::size_t s = 0; s < sides.size(); ++s) {
    auto load = loads.col(static_cast<Eigen::Index>(s));
    for (int a = 0; a < weights.cols(); ++a) {
      const double weight = weights(sides[s].row, a);
      if (weight != 0) load.segment<3>(3 * a) = weight * sides[s].force_W;
    }
  }
  free.SolveLoads(loads);
}

void HeldCompliance::RespondTo(const SparseRow& b, Eigen::Ref<Eigen::MatrixXd> response) const {
  free_.RespondTo(b, response);
  const std::span<const PairHold::Side> sides = hold_.sides(body_);
  if (sides.empty()) return;
  HeldColumns moved = HeldColumns::Zero(hold_.size(), 3);
  const auto weights = contacts_.Weights();
  for (const PairHold::Side& side : sides) {
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int a = 0; a < weights.cols(); ++a) {
      if (weights(side.row, a) == 0) continue;
      const Matrix3d point = response.block<3, 3>(3 * a, 0);
      sum += weights(side.row, a) * (side.axis_W.transpose() * point);
    }
    moved.row(side.place) += sum;
  }
  HeldColumns forces(hold_.size(), 3);
  // A general product would take a megabyte of the stack for its blocks.
  forces.noalias() = hold_.stiffness().lazyProduct(moved);
  for (std::size_t s = 0; s < sides.size(); ++s) {
    response.noalias() -= scratch_->col(static_cast<Eigen::Index>(s)).head(3 * weights.cols()) *
                          forces.row(sides[s].place);
  }
}

}  // namespace hpdm
