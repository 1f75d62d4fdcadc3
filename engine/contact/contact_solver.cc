#include "engine/contact/contact_solver.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

// Relative round-off of positions, from the tools' poses.
constexpr double kRoundOff = 1e-12;

// Rounds of Newton's method for the tips' local laws, and the last change of a force over the
// largest. From no force it takes four to seven.
constexpr int kMaxTipRounds = 16;
constexpr double kTipTolerance = 1e-8;

}  // namespace

void ContactSolver::Build(const ContactConstraints& contacts) {
  size_ = 0;
  has_tip_law_ = false;
  for (int i = 0; i < contacts.size(); ++i) {
    const ContactConstraints::Row& row = contacts[i];
    if (row.kind == ContactConstraints::RowKind::kPress) {
      equations_[size_++] = {i, -row.normal_W, row.friction_W - row.normal_W, true};
    } else {
      for (int d = 0; d < 3; ++d)
        equations_[size_++] = {i, Vector3d::Unit(d), Vector3d::Unit(d), false};
    }
  }
  change_.resize(size_);
  forces_.setZero(size_);
  compliance_.resize(size_, size_);
  for (int e = 0; e < size_; ++e) {
    const ContactConstraints::Row& row = contacts[equations_[e].row];
    change_[e] = equations_[e].axis_W.dot(row.target_W - row.p_rest_W);
    // Round-off must not make coincident contacts at rest contradict each other and slip.
    const double size = std::max(row.target_W.norm(), row.p_rest_W.norm());
    if (std::abs(change_[e]) <= kRoundOff * size) change_[e] = 0;
    local_[e] = row.local_compliance_W * equations_[e].force_W;
    const bool is_tip = equations_[e].unilateral && row.indentation.indents();
    tip_laws_[e].indentation = is_tip ? &row.indentation : nullptr;
    tip_laws_[e].along =
        equations_[e].axis_W.dot(row.indentation.factor_W() * equations_[e].force_W);
    has_tip_law_ = has_tip_law_ || is_tip;
    coupled_[e] = row.coupled;
  }
}

void ContactSolver::AddLocalCompliance() {
  for (int e = 0; e < size_; ++e) {
    for (int g = 0; g < size_; ++g) {
      if (equations_[e].row == equations_[g].row) {
        compliance_(e, g) += equations_[e].axis_W.dot(local_[g]);
      } else if (coupled_[e].coupling != nullptr) {
        compliance_(e, g) +=
            equations_[e].axis_W.dot(coupled_[e].To(coupled_[g]) * equations_[g].force_W);
      }
    }
  }
}

void ContactSolver::LineariseTipLaws() {
  for (int e = 0; e < size_; ++e) {
    const TipLaw& law = tip_laws_[e];
    if (law.indentation == nullptr) continue;
    const double f = std::max(forces_[e], 0.0);
    const double rate = law.indentation->BallYieldRate(f);
    compliance_(e, e) = law.compliance + law.along * rate;
    change_[e] = law.change - law.along * f * (law.indentation->BallYield(f) - rate);
  }
}

RelaxationResult ContactSolver::Solve() {
  RelaxationResult result;
  AddLocalCompliance();
  if (!has_tip_law_) {
    SolveLinear(&result);
    return result;
  }
  for (int e = 0; e < size_; ++e) {
    tip_laws_[e].compliance = compliance_(e, e);
    tip_laws_[e].change = change_[e];
  }
  Vector last = forces_;
  for (int round = 0; round < kMaxTipRounds; ++round) {
    LineariseTipLaws();
    SolveLinear(&result);
    if ((forces_ - last).cwiseAbs().maxCoeff() <= kTipTolerance * forces_.cwiseAbs().maxCoeff())
      break;
    last = forces_;
  }
  return result;
}

void ContactSolver::SolveLinear(RelaxationResult* result) {
  // Presses that have a gap without force start inactive.
  for (int e = 0; e < size_; ++e) active_[e] = !equations_[e].unilateral || change_[e] > 0;
  // Each round releases the presses that would pull and adds those that would penetrate.
  constexpr int kMaxRounds = 2 * kMaxContacts;
  bool changed = true;
  for (int round = 0; changed && round < kMaxRounds; ++round) {
    ++result->iterations;
    result->regularised = SolveActive();
    changed = UpdateActiveSet();
  }
  result->converged = !changed;
}

// Computes the forces that satisfy the active equations; the others are zero. True if the equations
// are (nearly) dependent.
bool ContactSolver::SolveActive() {
  forces_.setZero();
  slip_ = 0;
  int count = 0;
  for (int e = 0; e < size_; ++e) {
    if (active_[e]) active_list_[count++] = e;
  }
  if (count == 0) return false;
  double way = 0, stiffest = compliance_(active_list_[0], active_list_[0]), softest = 0;
  for (int i = 0; i < count; ++i) {
    const int e = active_list_[i];
    way = std::max(way, std::abs(change_[e]));
    stiffest = std::min(stiffest, compliance_(e, e));
    softest = std::max(softest, compliance_(e, e));
  }
  const bool friction = HasFriction();
  const auto solve = [&](double pad) {
    active_compliance_.resize(count, count);
    active_forces_.resize(count);
    for (int i = 0; i < count; ++i) {
      active_forces_[i] = change_[active_list_[i]];
      for (int j = 0; j < count; ++j) {
        active_compliance_(i, j) = compliance_(active_list_[i], active_list_[j]);
      }
    }
    active_compliance_.diagonal().array() += pad;
    if (friction) {
      const Eigen::PartialPivLU<Eigen::Ref<Matrix>> factor(active_compliance_);
      active_forces_ = factor.solve(active_forces_).eval();
      return factor.matrixLU().diagonal().cwiseAbs().minCoeff() < 10 * pad;
    }
    const Eigen::LDLT<Eigen::Ref<Matrix>> factor(active_compliance_);
    factor.solveInPlace(active_forces_);
    return factor.vectorD().minCoeff() < 10 * pad;
  };
  // With a pad compliance of 1e-9 of the softest contact, coincident contacts share their force.
  // Other contacts move by one part in 1e9.
  double pad = 1e-9 * softest;
  bool dependent = solve(pad);
  const double alone = way / stiffest;
  if (active_forces_.cwiseAbs().maxCoeff() > kContradicting * alone) {
    while (active_forces_.cwiseAbs().maxCoeff() > kSlipping * alone && pad < softest) {
      pad *= 10;
      solve(pad);
    }
    dependent = true;
    slip_ = pad;
  }
  for (int i = 0; i < count; ++i) forces_[active_list_[i]] = active_forces_[i];
  return dependent;
}

bool ContactSolver::HasFriction() const {
  for (int e = 0; e < size_; ++e) {
    if (equations_[e].force_W != equations_[e].axis_W) return true;
  }
  return false;
}

bool ContactSolver::UpdateActiveSet() {
  bool changed = false;
  const double slack = 1e-9 * change_.cwiseAbs().maxCoeff();  // round-off of the solve, in any unit
  for (int e = 0; e < size_; ++e) {
    if (!equations_[e].unilateral) continue;
    if (active_[e] ? forces_[e] < 0 : change_[e] - compliance_.row(e).dot(forces_) > slack) {
      active_[e] = !active_[e];
      changed = true;
    }
  }
  return changed;
}

void ContactSolver::WriteForces(ContactConstraints* contacts) const {
  for (int i = 0; i < contacts->size(); ++i) {
    (*contacts)[i].force_W.setZero();
    (*contacts)[i].slip = slip_;
  }
  for (int e = 0; e < size_; ++e) {
    (*contacts)[equations_[e].row].force_W += forces_[e] * equations_[e].force_W;
  }
}

}  // namespace hpdm
