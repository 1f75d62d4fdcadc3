#include "engine/duct/duct_state.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <utility>

namespace hpdm {
namespace {

// m. Ends that have moved by less are at rest.
constexpr double kRest = 1e-9;
// A change of the forces that a step does not see: a share of them, and in N.
constexpr double kSettledShare = 1e-3, kSettledForce = 1e-6;
// A metal clip bends so much less than the tube in it.
constexpr double kClipStiffness = 100;

}  // namespace

DuctState::DuctState(std::shared_ptr<const DuctModel> model)
    : model_(std::move(model)), rod_(model_->rod), frames_(rod_.rest_ends()) {
  for (std::size_t end = 0; end < 2; ++end) unknowns_ += model_->IsHeldByLattice(end) ? 12 : 0;
  map_.setZero(12, unknowns_);
  w_.setZero(unknowns_);
  constant_ = forces_ = w_;
  stiffness_.setZero(unknowns_, unknowns_);
  Follow(Eigen::VectorXd::Zero(unknowns_));
}

void DuctState::SetFrame(std::size_t end, const Isometry3d& X_WF) {
  X_WF_[end] = X_WF;
  has_frame_[end] = true;
}

// Fills the ends' frames and their map. True if they differ from the last ones.
bool DuctState::FindFrames(const Eigen::Ref<const Eigen::VectorXd>& w) {
  bool moved = false;
  Eigen::Index at = 0;
  for (std::size_t end = 0; end < 2; ++end) {
    const Rod::Frame& rest = rod_.rest_ends()[end];
    Rod::Frame frame = rest;
    if (model_->IsHeldByLattice(end)) {
      const EndMotion motion =
          EndMotionOf(rest, model_->holds[end].length, w.segment<12>(at), turns_[end]);
      frame = motion.frame;
      turns_[end] = motion.turn;
      auto map = map_.block<6, 12>(static_cast<Eigen::Index>(6 * end), at);
      map = motion.map;
      if (has_frame_[end]) {
        const Matrix3d R_WF = X_WF_[end].linear();
        frame.p_W = X_WF_[end] * frame.p_W;
        frame.R_W = R_WF * frame.R_W;
        map.topRows<3>() = R_WF * motion.map.topRows<3>();
        map.bottomRows<3>() = R_WF * motion.map.bottomRows<3>();
      }
      at += 12;
    }
    frame.p_W += offsets_W_[end];
    moved = moved || frame.p_W != frames_[end].p_W || frame.R_W != frames_[end].R_W;
    frames_[end] = frame;
  }
  return moved;
}

bool DuctState::Follow(const Eigen::Ref<const Eigen::VectorXd>& w) {
  const bool moved = FindFrames(w);
  if (!moved && !changed_) return true;
  const Vector predicted = constant_ + stiffness_ * w;
  at_rest_ = rod_.cuts() == 0 && !rod_.HoldsNode() && !has_frame_[0] && !has_frame_[1] &&
             w.isZero(kRest) && offsets_W_[0].isZero(kRest) && offsets_W_[1].isZero(kRest);
  bool unsettled = false;
  if (at_rest_) {
    rod_.Reset();
    const Vector rest = Vector::Zero(unknowns_);
    FindFrames(rest);
    frames_ = rod_.rest_ends();
    rod_.Settle(frames_);
    Linearise(rest);
  } else {
    unsettled = !rod_.Settle(frames_).converged;
    Linearise(w);
  }
  changed_ = unsettled;
  if (!forces_.allFinite() || !stiffness_.allFinite()) {
    rod_.Reset();
    forces_.setZero();
    constant_.setZero();
    stiffness_.setZero();
    return true;
  }
  const double difference = (forces_ - predicted).norm();
  return difference <= kSettledShare * forces_.norm() + kSettledForce;
}

void DuctState::Linearise(const Eigen::Ref<const Eigen::VectorXd>& w) {
  Rod::EndMatrix tangent;
  rod_.Condense(&gradient_, &tangent);
  w_ = w;
  forces_.noalias() = map_.transpose() * gradient_;
  const Eigen::Matrix<double, 12, Eigen::Dynamic, 0, 12, kMaxUnknowns> turned = tangent * map_;
  stiffness_.noalias() = map_.transpose() * turned;
  stiffness_ = ((stiffness_ + stiffness_.transpose()) / 2).eval();
  constant_ = forces_ - stiffness_ * w_;
}

void DuctState::Stabilise() {
  if (unknowns_ == 0) return;
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(stiffness_);
  const Vector kept = solver.eigenvalues().cwiseMax(0);
  stiffness_ = solver.eigenvectors() * kept.asDiagonal() * solver.eigenvectors().transpose();
  constant_ = forces_ - stiffness_ * w_;
}

// Returns the node nearest to an arc length, or -1 within two segments of an end or a gap.
int DuctState::InnerNodeAt(double arc) const {
  int nearest = 0;
  for (int i = 1; i < rod_.nodes(); ++i) {
    if (std::abs(rod_.ArcLength(i) - arc) < std::abs(rod_.ArcLength(nearest) - arc)) nearest = i;
  }
  if (nearest < 2 || nearest + 2 >= rod_.nodes()) return -1;
  for (int i = nearest - 2; i <= nearest + 1; ++i) {
    if (!rod_.IsSegment(i)) return -1;
  }
  return nearest;
}

bool DuctState::Clip(double arc) {
  for (int i = 1; i + 2 < rod_.nodes(); ++i) {
    if (!rod_.IsSegment(i) || arc < rod_.ArcLength(i) || arc >= rod_.ArcLength(i + 1)) continue;
    if (rod_.IsStiffened(i)) return false;
    rod_.Stiffen(i, kClipStiffness);
    clip_arcs_[ToSize(clips_++)] = arc;
    changed_ = true;
    at_rest_ = false;
    return true;
  }
  return false;
}

ClipsBeside DuctState::ClipsBesideOf(double arc) const {
  ClipsBeside beside;
  for (std::size_t c = 0; c < ToSize(clips_); ++c) {
    beside.gap = std::min(beside.gap, std::abs(clip_arcs_[c] - arc));
    ++(clip_arcs_[c] < arc ? beside.before : beside.after);
  }
  return beside;
}

int DuctState::NodeToCut(double arc) const {
  const int node = InnerNodeAt(arc);
  if (node < 0) return -1;
  const double at = rod_.ArcLength(node);
  if (ClipsBesideOf(at).before == ClipsBesideOf(arc).before) return node;
  return InnerNodeAt(rod_.ArcLength(at > arc ? node - 1 : node + 1));
}

int DuctState::Cut(double arc) {
  const int node = NodeToCut(arc);
  if (node < 0 || rod_.IsHeld(node) || !rod_.Cut(node)) return -1;
  changed_ = true;
  at_rest_ = false;
  return node;
}

int DuctState::NodeToHold(double arc) const {
  const int node = InnerNodeAt(arc);
  return node < 0 || rod_.IsHeld(node) ? -1 : node;
}

void DuctState::MoveHeld(int node, const Vector3d& place_W) {
  rod_.Hold(node, place_W);
  changed_ = true;
  at_rest_ = false;
}

void DuctState::Release(int node) {
  rod_.Release(node);
  changed_ = true;
  at_rest_ = false;
}

DuctState::HeldStiffness DuctState::StiffnessOf(int node) {
  const Rod::NodeStiffness stiffness = rod_.StiffnessOf(node);
  HeldStiffness held;
  held.node = stiffness.node;
  held.rows = map_.transpose() * stiffness.ends;
  return held;
}

DuctOutcome DuctState::Outcome() const {
  DuctOutcome outcome;
  outcome.load_W = -gradient_.segment<3>(6);
  outcome.clips = clips_;
  outcome.cuts = rod_.cuts();
  for (int i = 0; i + 1 < rod_.nodes(); ++i) {
    if (!rod_.IsSegment(i)) continue;
    outcome.tension = std::max(outcome.tension, rod_.ForceIn(i).z());
    outcome.length += (rod_.node(i + 1) - rod_.node(i)).norm();
  }
  return outcome;
}

DuctSnapshot SnapshotOf(const Rod& rod) {
  DuctSnapshot snapshot;
  snapshot.nodes = std::min(rod.nodes(), kMaxDuctNodes);
  for (int i = 0; i < snapshot.nodes; ++i) {
    snapshot.nodes_W[ToSize(i)] = rod.node(i).cast<float>();
    if (i + 1 == rod.nodes()) continue;
    if (rod.IsStiffened(i)) snapshot.segments[ToSize(i)] = SegmentState::kClipped;
    if (!rod.IsSegment(i)) snapshot.segments[ToSize(i)] = SegmentState::kGap;
  }
  return snapshot;
}

}  // namespace hpdm
