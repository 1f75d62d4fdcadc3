#include "engine/attachment/attachment_link.h"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// The least stiffness of a held duct over its largest.
constexpr double kLeastHeldShare = 1e-4;
// N. The forces of a rod in equilibrium are so much off.
constexpr double kNoForce = 1e-6;

// Adds rows^T v, a row of three at a time: rows are contiguous. `rows`: 3 x 3r.
template <class Rows, class Column>
void AddRows(const Rows& rows, const Vector3d& v, Column&& column) {
  column += (v[0] * rows.row(0) + v[1] * rows.row(1) + v[2] * rows.row(2)).transpose();
}

bool IsOf(std::size_t member, const std::array<int, 2>& members) {
  return members[0] == static_cast<int>(member) || members[1] == static_cast<int>(member);
}

}  // namespace

AttachmentLink::AttachmentLink(std::shared_ptr<const AttachmentJoint> joint)
    : state_(std::move(joint)),
      outcomes_(state_.joint().layers().size()),
      equations_(2 * ContactSolver::kMaxEquations),
      along_(3 * state_.joint().modes(), 2 * ContactSolver::kMaxEquations),
      loaded_(along_),
      half_along_(JointSolver::MostHalfSize(state_.joint()), along_.cols()),
      half_(half_along_),
      let_go_(state_.joint().members().size(), 0),
      apart_(Eigen::VectorXd::Zero(along_.rows())),
      free_(apart_),
      w_(apart_),
      q_(apart_),
      relief_(apart_) {
  Eigen::Index unknowns = 0;
  for (std::size_t m = 0; m < let_go_.size(); ++m) {
    if (HasDucts(m)) unknowns = std::max(unknowns, state_.joint().members()[m].unknowns());
  }
  moved_.setZero(unknowns);
  state_.Report(w_, outcomes_);  // the weight that the layers bear
}

bool AttachmentLink::HasDucts(std::size_t member) const {
  return std::ranges::any_of(joint().ducts(), [&](const AttachmentJoint::Duct& duct) {
    return IsOf(member, duct.members);
  });
}

bool AttachmentLink::IsMovedApart(std::span<const Vector3d> offsets_W) const {
  for (const DuctState& duct : state_.ducts()) {
    if (!duct.AtRest() || !offsets_W[0].isZero(0)) return true;
  }
  for (const Vector3d& offset_W : offsets_W) {
    if (offset_W != offsets_W[0]) return true;
  }
  return false;
}

void AttachmentLink::Begin(std::span<const Vector3d> offsets_W, std::span<const int> bodies) {
  HPDM_CHECK(bodies.size() == joint().members().size());
  round_ = 0;
  apart_.setZero();
  acted_ = false;
  for (std::size_t m = 0; m < bodies.size(); ++m) {
    bodies_[m] = bodies[m];
    const Vector3d apart_W = offsets_W[m] - offsets_W[0];
    if (apart_W.isZero(0) || HasLetGo(m)) continue;
    const Eigen::VectorXd& excited = joint().members()[m].offset;
    for (Eigen::Index j = 0; j < excited.size(); ++j) {
      apart_.segment<3>(3 * j) += excited[j] * apart_W;
    }
  }
  // The modes are relative to the first member's offset.
  for (std::size_t d = 0; d < state_.ducts().size(); ++d) {
    DuctState& duct = state_.ducts()[d];
    for (std::size_t end = 0; end < 2; ++end) {
      const int member = joint().ducts()[d].members[end];
      if (member < 0) continue;
      const bool joined = duct.model().IsHeldByLattice(end) && !HasLetGo(ToSize(member));
      duct.SetOffset(end, offsets_W[joined ? 0 : ToSize(member)]);
    }
  }
}

// Moves all ducts with their organs. The frames of those let go are where these would be without forces.
void AttachmentLink::MoveFrames(std::span<const BodyInStep> bodies) {
  for (std::size_t d = 0; d < joint().ducts().size(); ++d) {
    for (std::size_t end = 0; end < 2; ++end) {
      const int member = joint().ducts()[d].members[end];
      if (member < 0 || !HasLetGo(ToSize(member))) continue;
      ducts()[d].SetFrame(end, bodies[ToSize(bodies_[ToSize(member)])].body->PredictedFrame());
    }
  }
  state_.MoveDucts(w_);
}

Matrix3d AttachmentLink::ComplianceOf(std::size_t duct, int node) {
  const DuctState::HeldStiffness held = state_.ducts()[duct].StiffnessOf(node);
  Matrix3d stiffness = held.node;
  const Eigen::Index first = 3 * joint().ducts()[duct].first_mode, count = held.rows.rows();
  state_.Refactor();
  for (int d = 0; d < 3 && count > 0; ++d) {
    apart_.noalias() = Compliance().middleCols(first, count) * held.rows.col(d);
    state_.solver().FindForces(apart_, &q_, &free_);
    stiffness.col(d) -= held.rows.transpose() * free_.segment(first, count);
  }
  // A buckled rod may give way at the node.
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver((stiffness + stiffness.transpose()) / 2);
  const double largest = solver.eigenvalues().cwiseAbs().maxCoeff();
  if (!(largest > 0) || !std::isfinite(largest)) return Matrix3d::Zero();
  const Vector3d kept = solver.eigenvalues().cwiseMax(kLeastHeldShare * largest);
  return solver.eigenvectors() * kept.cwiseInverse().asDiagonal() *
         solver.eigenvectors().transpose();
}

// A free or a leaking organ moves also without forces.
void AttachmentLink::AddFreeDisplacements(std::span<const BodyInStep> bodies) {
  for (std::size_t m = 0; m < joint().members().size(); ++m) {
    const BodyInStep& body = bodies[ToSize(bodies_[m])];
    // The modes of a member let go are in its frame, and so is what it moves there without forces.
    const Points* U = HasLetGo(m) ? nullptr : body.body->FreeDisplacements();
    if (U == nullptr) U = body.input.free;
    if (U == nullptr || (HasLetGo(m) && !HasDucts(m))) continue;
    const Eigen::MatrixXd& shape = joint().members()[m].shape;
    HPDM_CHECK(shape.cols() <= U->rows());
    for (Eigen::Index a = 0; a < shape.cols(); ++a) {
      const Vector3d moved_W = U->row(a);
      for (Eigen::Index j = 0; j < shape.rows(); ++j) {
        apart_.segment<3>(3 * j) += shape(j, a) * moved_W;
      }
    }
  }
}

// Fills the columns of all sides of the members' bodies, which stay in all rounds of a step.
void AttachmentLink::FillColumns(std::span<const BodyInStep> bodies, const ContactSolver& solver) {
  column_count_ = 0;
  same_ = true;
  for (std::size_t m = 0; m < joint().members().size(); ++m) {
    const AttachmentJoint::Member& member = joint().members()[m];
    if (member.unknowns() == 0 || (HasLetGo(m) && !HasDucts(m))) continue;
    const BodyInStep& body = bodies[static_cast<std::size_t>(bodies_[m])];
    HPDM_CHECK(body.input.yield == 1);
    const auto weights = body.contacts->Weights();
    const Matrix3d R_FW = body.body->PredictedFrame().linear().transpose();
    for (const ContactSolver::Side& side : solver.sides(bodies_[m])) {
      const auto k = static_cast<Eigen::Index>(column_count_);
      equations_[column_count_++] = side.equation;
      same_ = same_ && side.force_W == side.axis_W;
      auto along = along_.col(k), loaded = loaded_.col(k);
      along.setZero();
      loaded.setZero();
      const Vector3d axis = HasLetGo(m) ? Vector3d(R_FW * side.axis_W) : side.axis_W;
      const Vector3d force = HasLetGo(m) ? Vector3d(R_FW * side.force_W) : side.force_W;
      const bool same = side.force_W == side.axis_W;
      for (Eigen::Index a = 0; 3 * a < member.unknowns(); ++a) {
        const double weight = weights(side.row, a);
        if (weight == 0) continue;
        const auto response = member.response.middleRows<3>(3 * a);
        AddRows(response, weight * axis, along);
        if (!same) AddRows(response, weight * force, loaded);
      }
      if (same) loaded = along;
    }
  }
}

// Adds the modes' displacements by the constant forces. Those of the layers are zero without a weight; with
// one they nearly cancel those of the ducts, so the sum is not split.
void AttachmentLink::MoveByConstant() {
  const Eigen::VectorXd& constant = state_.constant();
  Eigen::Index layers = constant.size();
  for (const AttachmentJoint::Duct& duct : joint().ducts()) layers -= 3 * duct.modes();
  if (!constant.head(layers).isZero(0)) layers = 0;
  const Eigen::Index others = constant.size() - layers;
  free_.noalias() -= Compliance().rightCols(others) * constant.tail(others);
}

void AttachmentLink::Linearise(std::span<const BodyInStep> bodies, ContactSolver* solver) {
  if (round_++ == 0) {
    MoveFrames(bodies);
    FillColumns(bodies, *solver);
    AddFreeDisplacements(bodies);
    apart_ += relief_;
    state_.Refactor();
  } else {
    state_.RefactorOrDefer(w_);
  }
  free_ = apart_;
  MoveByConstant();
  state_.solver().FindForces(free_, &q_);
  q_ += state_.constant();
  const auto count = static_cast<Eigen::Index>(column_count_);
  for (Eigen::Index e = 0; e < count; ++e) {
    solver->change()[equations_[ToSize(e)]] += along_.col(e).dot(q_);
  }
  const Eigen::Index size = state_.solver().half_size();
  auto half = half_.topLeftCorner(size, count), half_along = half_along_.topLeftCorner(size, count);
  state_.solver().Halve(loaded_.leftCols(count), half);
  if (same_) {
    half_along = half;
  } else {
    state_.solver().Halve(along_.leftCols(count), half_along);
  }
  state_.solver().TakeDuctForces(half);
  for (Eigen::Index g = 0; g < count; ++g) {
    for (Eigen::Index e = 0; e < count; ++e) {
      solver->AddCompliance(equations_[ToSize(e)], equations_[ToSize(g)],
                            -half_along.col(e).dot(half.col(g)), 1);
    }
  }
}

bool AttachmentLink::Advance(const ContactSolver& solver) {
  for (std::size_t k = 0; k < column_count_; ++k) {
    free_ += solver.forces()[equations_[k]] * loaded_.col(static_cast<Eigen::Index>(k));
  }
  state_.solver().FindForces(free_, &q_, &w_);
  if (!w_.allFinite()) {  // the caller reports the organs' displacements
    w_.setZero();
    q_.setZero();
  }
  q_ += state_.constant();
  return state_.Update(w_) || round_ >= MaxRounds();
}

int AttachmentLink::MaxRounds() const {
  for (std::size_t m = 0; m < let_go_.size(); ++m) {
    if (HasLetGo(m) && HasDucts(m)) return kMaxTiedRounds;
  }
  return kMaxRounds;
}

void AttachmentLink::End(std::span<BodyInStep> bodies) {
  for (std::size_t m = 0; m < joint().members().size(); ++m) {
    const AttachmentJoint::Member& member = joint().members()[m];
    if (member.unknowns() == 0 || (HasLetGo(m) && !HasDucts(m))) continue;
    const BodyInStep& body = bodies[static_cast<std::size_t>(bodies_[m])];
    Eigen::Map<Eigen::VectorXd> U(body.U->data(), member.unknowns());
    if (!HasLetGo(m)) {
      U.noalias() -= member.response * q_;
      continue;
    }
    ForcesOfDucts(m, &free_);
    if (!(free_.cwiseAbs().maxCoeff() > kNoForce)) continue;
    auto moved = moved_.head(member.unknowns());
    moved.noalias() = member.response * free_;
    const Matrix3d R_WF = body.body->PredictedFrame().linear();
    for (Eigen::Index a = 0; a < U.size(); a += 3) {
      U.segment<3>(a) -= R_WF * moved.segment<3>(a);
    }
  }
  state_.Report(w_, outcomes_);
  LetGo(bodies);
}

// Lets go of free organs that no layer holds any more.
void AttachmentLink::LetGo(std::span<BodyInStep> bodies) {
  for (std::size_t m = 0; m < joint().members().size(); ++m) {
    if (!joint().members()[m].free || HasLetGo(m)) continue;
    const auto holds = [&](std::size_t l) {
      const AttachmentJoint::Layer& layer = joint().layers()[l];
      return layer.members[0] == static_cast<int>(m) || layer.members[1] == static_cast<int>(m);
    };
    bool held = false;
    for (std::size_t l = 0; l < joint().layers().size(); ++l) {
      held = held || (holds(l) && !state_.IsTorn(l));
    }
    if (held) continue;
    let_go_[m] = 1;
    for (std::size_t l = 0; l < joint().layers().size(); ++l) {
      if (holds(l)) state_.TakeAway(l);
    }
    const BodyInStep& body = bodies[ToSize(bodies_[m])];
    body.body->TakeMoved(body.U);
    body.body->SetHeld(false);
    if (!HasDucts(m)) continue;
    body.body->Tie();
    FindRelief(m);
  }
}

// From now on the modes of the member's ducts are displacements in its frame.
void AttachmentLink::FindRelief(std::size_t member) {
  state_.Refactor();
  q_.setZero();
  for (const AttachmentJoint::Layer& layer : joint().layers()) {
    if (!IsOf(member, layer.members)) continue;
    const Eigen::Index first = 3 * layer.first_mode, count = 3 * layer.samples.rows();
    q_.segment(first, count) = state_.constant().segment(first, count);
  }
  const AttachmentJoint::Member& freed = joint().members()[member];
  auto moved = moved_.head(freed.unknowns());
  moved.noalias() = freed.response * q_;
  for (const AttachmentJoint::Duct& duct : joint().ducts()) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (duct.members[end] != static_cast<int>(member)) continue;
      const Eigen::Index first = duct.FirstModeOf(end);
      w_.segment(3 * first, 3 * DuctModel::Hold::kRows).setZero();
      for (Eigen::Index j = first; j < first + DuctModel::Hold::kRows; ++j) {
        for (Eigen::Index a = 0; a < freed.shape.cols(); ++a) {
          relief_.segment<3>(3 * j) += freed.shape(j, a) * moved.segment<3>(3 * a);
        }
      }
    }
  }
}

// Fills q with the last solution's forces of ducts on the member, N.
void AttachmentLink::ForcesOfDucts(std::size_t member, Eigen::VectorXd* q) const {
  q->setZero();
  for (const AttachmentJoint::Duct& duct : joint().ducts()) {
    for (std::size_t end = 0; end < 2; ++end) {
      if (duct.members[end] != static_cast<int>(member)) continue;
      const Eigen::Index first = 3 * duct.FirstModeOf(end), count = 3 * DuctModel::Hold::kRows;
      q->segment(first, count) = q_.segment(first, count);
    }
  }
}

// Moves the ducts of members let go to where these have come.
void AttachmentLink::Follow(std::span<const BodyInStep> bodies) {
  for (std::size_t d = 0; d < joint().ducts().size(); ++d) {
    const AttachmentJoint::Duct& joined = joint().ducts()[d];
    DuctState& duct = ducts()[d];
    bool moves = false;
    auto w = q_.head(duct.unknowns());
    w = w_.segment(3 * joined.first_mode, duct.unknowns());
    for (std::size_t end = 0; end < 2; ++end) {
      const int member = joined.members[end];
      if (member < 0 || !HasLetGo(ToSize(member))) continue;
      const BodyInStep& body = bodies[ToSize(bodies_[ToSize(member)])];
      const Isometry3d X_WF = body.body->Frame();
      const DuctModel::Hold& hold = joined.model->holds[end];
      const Vector3d p_rest_W = joined.model->rod.rest_ends()[end].p_W;
      const Eigen::Index first = 3 * (joined.FirstModeOf(end) - joined.first_mode);
      for (int r = 0; r < DuctModel::Hold::kRows; ++r) {
        // The rows of the rigid motion.
        Vector3d moved_W = -(X_WF * p_rest_W - p_rest_W);
        if (r > 0) moved_W = hold.length * (Vector3d::Unit(r - 1) - X_WF.linear().col(r - 1));
        for (const auto& [column, value] : hold.rows[ToSize(r)]) {
          moved_W += value * body.U->row(column).transpose();
        }
        w.segment<3>(first + 3 * r) = X_WF.linear().transpose() * moved_W;
      }
      if (!w.allFinite()) w.setZero();
      duct.SetFrame(end, X_WF);
      moves = true;
    }
    if (moves) duct.Follow(w);
  }
}

void AttachmentLink::Keep() {
  HPDM_CHECK(kept_.has_value());
  kept_->state = state_.solved();
  kept_->w = w_;
  kept_->relief = relief_;
  kept_->let_go = let_go_;
}

void AttachmentLink::TakeBack() {
  HPDM_CHECK(kept_.has_value());
  state_.TakeBack(kept_->state);
  w_ = kept_->w;
  relief_ = kept_->relief;
  let_go_ = kept_->let_go;
}

}  // namespace hpdm
