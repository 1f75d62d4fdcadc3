#include "engine/solver/schur_complement.h"

#include <algorithm>

namespace hpdm {
namespace {

constexpr double kRegularisation = 1e-9;

}  // namespace

SchurComplement::SchurComplement(const RefinementBasis& functions, int slots)
    : functions_(&functions),
      function_(slots, -1),
      weight_(slots, 1),
      stale_(slots),
      moved_(functions.inverse().rows()),
      reduced_(Eigen::MatrixXd::Identity(3 * slots, 3 * slots)),
      regular_(reduced_),
      factor_(reduced_) {}

void SchurComplement::Reduce(const Eigen::Ref<const Eigen::VectorXd>& f,
                             Eigen::Ref<Eigen::VectorXd> g) const {
  for (std::size_t s = 0; s < function_.size(); ++s) {
    if (function_[s] < 0) continue;
    g.segment(3 * static_cast<Eigen::Index>(s), 3).noalias() -=
        functions_->Coupling(function_[s]).transpose() * f;
  }
}

void SchurComplement::ReducePoint(int point, double weight, Eigen::Ref<Eigen::MatrixXd> g) const {
  for (std::size_t s = 0; s < function_.size(); ++s) {
    if (function_[s] < 0) continue;
    g.middleRows<3>(3 * static_cast<Eigen::Index>(s)) -=
        weight * functions_->Coupling(function_[s]).middleRows<3>(3 * point).transpose();
  }
}

void SchurComplement::AddCoupling(double factor, const Eigen::Ref<const Eigen::VectorXd>& V,
                                  Eigen::Ref<Eigen::VectorXd> U_bar) const {
  moved_.setZero();
  for (std::size_t s = 0; s < function_.size(); ++s) {
    if (function_[s] < 0) continue;
    const auto Y = functions_->Coupling(function_[s]);
    const auto v = V.segment<3>(3 * static_cast<Eigen::Index>(s));
    moved_ = moved_ + v[0] * Y.col(0) + v[1] * Y.col(1) + v[2] * Y.col(2);
  }
  U_bar += factor * moved_;
}

// Updates the parts of Sigma of the slots that changed. Returns whether any did.
bool SchurComplement::TakeSlots(const ActiveRefinement& active) {
  bool changed = false;
  for (int s = 0; s < active.slots(); ++s) {
    stale_[s] = function_[s] != active.Function(s);
    if (!stale_[s]) continue;
    changed = true;
    function_[s] = active.Function(s);
  }
  if (!changed) return false;
  for (int s = 0; s < active.slots(); ++s) {
    for (int t = 0; t <= s; ++t) {
      if (!stale_[s] && !stale_[t]) continue;
      Matrix3d block = Matrix3d::Zero();
      if (function_[s] >= 0 && function_[t] >= 0) {
        block = functions_->ReducedStiffness(function_[s], function_[t]);
      } else if (s == t) {
        block.setIdentity();
      }
      reduced_.block<3, 3>(3 * s, 3 * t) = block;
      reduced_.block<3, 3>(3 * t, 3 * s) = block.transpose();
    }
  }
  return true;
}

void SchurComplement::SetActiveFunctions(const ActiveRefinement& active) {
  bool changed = TakeSlots(active);
  for (int s = 0; s < active.slots(); ++s) {
    changed = changed || weight_[s] != active.Weight(s);
    weight_[s] = active.Weight(s);
  }
  if (!changed) return;
  // Local functions that together equal a function of the lattice have no stiffness in Sigma. It is
  // arbitrary which of the two moves.
  for (double extra = kRegularisation; extra < 1; extra *= 10) {
    regular_ = reduced_;
    for (int s = 0; s < active.slots(); ++s) regular_.block<3, 3>(3 * s, 3 * s) /= weight_[s];
    regular_.diagonal() *= 1 + extra;
    factor_.compute(regular_);
    if (factor_.info() == Eigen::Success) return;
  }
}

}  // namespace hpdm
