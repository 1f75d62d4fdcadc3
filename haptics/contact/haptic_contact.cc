#include "haptics/contact/haptic_contact.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "haptics/contact/reaction_force.h"

namespace hpdm {
namespace {

// Slip of a contact over its tip's motion along the surface and against it. Under a convex
// surface a press of half the radius of curvature slides twice as far as its tip.
constexpr double kSlipAlong = 2;
constexpr double kSlipAgainst = 0.5;

// m. A tip that moves farther in a tick may have passed through a wall.
constexpr double kFarInATick = 5e-4;

// Largest turn of the normal by the force beyond the step's: its linear law holds up to here.
constexpr double kMaxTilt = 0.5;

// Ticks of one patch that are needed to extrapolate the force.
constexpr int kTicksToExtrapolate = 3;

template <class Value>
Value AtFoot(const ToolPatch& patch, const SurfaceFoot& foot, Value PatchPoint::*member) {
  return foot.weights[0] * (patch.points[foot.corners[0]].*member) +
         foot.weights[1] * (patch.points[foot.corners[1]].*member) +
         foot.weights[2] * (patch.points[foot.corners[2]].*member);
}

}  // namespace

HapticContact::HapticContact(double period) : fade_(std::exp(-period / kFade)) {}

void HapticContact::SetPatch(const ToolPatch& patch) noexcept {
  const bool same_organ = patch_ != nullptr && organ_ == patch.organ;
  started_ = started_ && same_organ;
  patch_ = &patch;
  organ_ = patch.organ;
  surface_.Build(patch);
  is_new_ = true;
  if (!touching_) return;
  if (!same_organ || !surface_.Find(foot_.mesh_triangle, foot_.weights, p_foot_W_, &foot_)) {
    LoseContact();
    fades_out_ = true;
  }
}

void HapticContact::ClearPatch() noexcept {
  patch_ = nullptr;
  organ_ = -1;
  LoseContact();
}

void HapticContact::LoseContact() {
  touching_ = false;
  force_W_.setZero();
  moved_W_.setZero();
  friction_W_.setZero();
}

void HapticContact::Locate(TipPose tip) noexcept {
  result_ = {};
  in_lattice_ = false;
  if (patch_ != nullptr) tip.X_WT.translation() -= patch_->motion.Offset(tip.time_ns);
  if (organ_ < 0) {
    LoseContact();
  } else if (patch_->kind == ContactKind::kGrasp && tip.jaw <= kJawLetsGo) {
    LoseContact();
    LocateGrasp(tip);
  } else {
    LocatePress(tip);
  }
  p_tip_last_W_ = tip.X_WT.translation();
  started_ = true;
}

HapticForce HapticContact::Evaluate(const TipPose& tip) noexcept {
  Locate(tip);
  Solve(this);
  return result_;
}

void HapticContact::LocateGrasp(const TipPose& tip) {
  const Vector3d p_W = tip.X_WT * patch_->p_grasp_T;
  result_.organ = organ_;
  result_.kind = ContactKind::kGrasp;
  if (patch_->reaction == ReactionType::kPaper) {
    result_.reaction_W = ForceOnHand(patch_->grasp_node, p_W - patch_->p_original_W);
    return;
  }
  in_lattice_ = true;
  tip_ = {.holds = true,
          .p_original_W = patch_->p_original_W,
          .compliance_W = patch_->compliance_W,
          .p_current_W = p_W};
  coupling_W_ = patch_->coupling_W;
}

void HapticContact::LocatePress(const TipPose& tip) {
  const bool was_touching = touching_;
  if (!was_touching && !FindContact(tip)) return;
  touching_ = true;
  EvaluateAtFoot(tip);
  if (was_touching) Slide(tip);
  p_foot_W_ = surface_.Position(foot_);
  if (patch_->reaction == ReactionType::kPaper) {
    if (tip_.depth > 0) {
      PressPaper();
    } else {
      LoseContact();
    }
    return;
  }
  if (!was_touching) Sticks(tip);
  friction_W_ -= friction_W_.dot(tip_.normal_W) * tip_.normal_W;  // the normal turned with the slip
  tip_.friction_W = friction_W_;
  in_lattice_ = true;
}

bool HapticContact::FindContact(const TipPose& tip) {
  const Vector3d& p_tip_W = tip.X_WT.translation();
  if (started_ && (p_tip_W - p_tip_last_W_).norm() > kFarInATick &&
      surface_.FindEntry(p_tip_last_W_, p_tip_W, &foot_)) {
    return true;
  }
  return surface_.FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius;
}

void HapticContact::EvaluateAtFoot(const TipPose& tip) {
  tip_ = {};
  tip_.p_original_W = AtFoot(*patch_, foot_, &PatchPoint::p_original_W);
  tip_.normal_W = foot_.normal_W;
  if (patch_->reaction == ReactionType::kLattice) {
    tip_.normal_W = PressedNormal();
    tip_.compliance_W = AtFoot(*patch_, foot_, &PatchPoint::compliance_W);
    coupling_W_ = AtFoot(*patch_, foot_, &PatchPoint::coupling_W);
  }
  tip_.depth = tip_.normal_W.dot(tip_.p_original_W - tip.X_WT.translation()) + tip.tip_radius;
}

// Uses the f_n of the last tick but the direction of the normal to be found. With both from the
// last tick they would oscillate.
Vector3d HapticContact::PressedNormal() const {
  const Vector3d stands_W = foot_.normal_W + patch_->tilt_W;
  const double pressing = -force_W_.dot(foot_.normal_W);
  const Matrix3d turn = pressing * patch_->tilt_compliance_W;
  const Vector3d n =
      (Matrix3d::Identity() + turn).inverse() *
      (stands_W - patch_->tilt_compliance_W * patch_->force_on_tissue_W + turn * friction_W_);
  const Vector3d further_W = n - stands_W;
  const double share = std::min(1.0, kMaxTilt / std::max(further_W.norm(), 1e-300));
  if (!further_W.allFinite()) return stands_W.stableNormalized();
  return (stands_W + share * further_W).stableNormalized();
}

// True if friction holds the contact in place; sets the friction that acts.
bool HapticContact::Sticks(const TipPose& tip) {
  friction_W_.setZero();
  if (!(tip.friction > 0) || patch_->reaction == ReactionType::kPaper) return false;
  const Vector3d& n = tip_.normal_W;
  const Vector3d target_W = tip.X_WT.translation() - tip.tip_radius * n;
  const Vector3d hold_W = tip_.compliance_W.ldlt().solve(target_W - tip_.p_original_W - moved_W_);
  const double pressing = -n.dot(hold_W);
  if (!(pressing > 0)) return false;
  const Vector3d share_W = (hold_W + pressing * n) / pressing;
  const double share = share_W.norm();
  friction_W_ = share > tip.friction ? Vector3d(tip.friction / share * share_W) : share_W;
  return share <= tip.friction;
}

// Returns the tangential part of x_tip - r n - x_c: the offset from the pressed point to the tip,
// m.
Vector3d HapticContact::TangentialOffset(const TipPose& tip) const {
  const Vector3d& n = tip_.normal_W;
  Vector3d offset_W = tip.X_WT.translation() - tip_.p_original_W - moved_W_;
  if (patch_->reaction == ReactionType::kLattice) {
    CondensedTip moved = tip_;
    moved.friction_W = friction_W_;
    moved.depth += n.dot(moved_W_);
    offset_W -= tip_.compliance_W * TipForce(moved);
  }
  return offset_W - n.dot(offset_W) * n;
}

void HapticContact::Slide(const TipPose& tip) {
  if (Sticks(tip)) return;
  const Vector3d tangential_W = TangentialOffset(tip);
  const Vector3d way_W = tip.X_WT.translation() - p_tip_last_W_;
  const double against = tip_.normal_W.dot(way_W);
  const double longest =
      kSlipAlong * (way_W - against * tip_.normal_W).norm() + kSlipAgainst * std::abs(against);
  const SurfaceFoot before = foot_;
  surface_.Walk(std::min(1.0, longest / std::max(tangential_W.norm(), 1e-300)) * tangential_W,
                &foot_);
  EvaluateAtFoot(tip);
  if (TangentialOffset(tip).squaredNorm() <= tangential_W.squaredNorm()) return;
  foot_ = before;
  EvaluateAtFoot(tip);
}

void HapticContact::PressPaper() {
  result_.normal_W = tip_.normal_W;
  result_.depth = tip_.depth;
  result_.organ = organ_;
  result_.kind = ContactKind::kPress;
  const Vector3d delta_W = -tip_.depth * tip_.normal_W;
  for (int i = 0; i < 3; ++i) {
    result_.reaction_W +=
        foot_.weights[i] * ForceOnHand(patch_->points[foot_.corners[i]].node, delta_W);
  }
  result_.reaction_W -= std::min(result_.reaction_W.dot(tip_.normal_W), 0.0) * tip_.normal_W;
}

void HapticContact::SetReaction(const Vector3d& force_on_tissue_W) {
  if (!tip_.holds) {
    if (force_on_tissue_W.squaredNorm() == 0) {
      LoseContact();
      return;
    }
    force_W_ = force_on_tissue_W;
    result_.organ = organ_;
    result_.kind = ContactKind::kPress;
    result_.normal_W = tip_.normal_W;
    result_.depth = std::max(tip_.depth, 0.0);
  }
  // Eq. 29 with delta = p_current - p_original, the latter displaced by the other tip's force. With
  // the springs C^-1 it returns -F up to rounding (engine/README.md, section 7, has the reason).
  const Vector3d delta_W = tip_.compliance_W * force_on_tissue_W;
  result_.reaction_W = ForceOnHand(NodeOfCompliance(tip_.compliance_W), delta_W);
}

// A patch that lasted for less than three ticks gives no extrapolation of the force, so there is
// nothing to fade in from. A contact without a place on the new patch fades out.
void HapticContact::FadeIn() {
  const Vector3d raw_W = result_.reaction_W;
  const bool arrives = is_new_ && ticks_of_patch_ >= kTicksToExtrapolate;
  if (is_new_) ticks_of_patch_ = 0;
  is_new_ = false;
  ++ticks_of_patch_;
  if (!raw_W.allFinite()) {  // the guard handles it
    offset_W_.setZero();
    ticks_of_patch_ = 0;
    return;
  }
  const bool in_contact = result_.kind != ContactKind::kNone;
  if (in_contact) fades_out_ = false;
  offset_W_ *= fade_;
  if (arrives && (in_contact || fades_out_)) {
    offset_W_ += 2 * raw_last_W_ - raw_before_W_ - raw_W;
  }
  raw_before_W_ = raw_last_W_;
  raw_last_W_ = raw_W;
  if (!in_contact) {
    if (!fades_out_) offset_W_.setZero();
    result_.reaction_W = offset_W_;
    return;
  }
  // The offset never exceeds the force itself, so it ends with the force and never pulls.
  offset_W_ *= std::min(1.0, raw_W.norm() / std::max(offset_W_.norm(), 1e-300));
  Vector3d& felt_W = result_.reaction_W;
  felt_W += offset_W_;
  felt_W -= std::min(felt_W.dot(result_.normal_W), 0.0) * result_.normal_W;
}

void HapticContact::Solve(HapticContact* tip) noexcept {
  tip->moved_W_.setZero();
  if (tip->in_lattice_) tip->SetReaction(TipForce(tip->tip_));
  tip->FadeIn();
}

void HapticContact::Solve(HapticContact* a, HapticContact* c) noexcept {
  if (!a->in_lattice_ || !c->in_lattice_ || a->organ_ != c->organ_) {
    Solve(a);
    Solve(c);
    return;
  }
  // Each foot's coupling assumes the other tip at its place in the step.
  const Matrix3d coupling_W = a->coupling_W_ + c->coupling_W_.transpose() - a->patch_->coupling_W;
  Vector3d force_a_W, force_c_W;
  TipForces(a->tip_, c->tip_, coupling_W, &force_a_W, &force_c_W);
  a->moved_W_ = coupling_W * force_c_W;
  c->moved_W_ = coupling_W.transpose() * force_a_W;
  a->SetReaction(force_a_W);
  c->SetReaction(force_c_W);
  a->FadeIn();
  c->FadeIn();
}

TickContactPoint HapticContact::contact_point() const noexcept {
  TickContactPoint contact_point;
  contact_point.known_organ = organ_;
  if (!touching_) return contact_point;
  contact_point.organ = organ_;
  contact_point.triangle = foot_.mesh_triangle;
  contact_point.weights = foot_.weights;
  contact_point.normal_W = tip_.normal_W;
  contact_point.friction_W = friction_W_;
  return contact_point;
}

}  // namespace hpdm
