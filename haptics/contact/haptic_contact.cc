#include "haptics/contact/haptic_contact.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "engine/step/tool_geometry.h"
#include "haptics/contact/reaction_force.h"

namespace hpdm {
namespace {

// Ticks of one patch that are needed to extrapolate the force.
constexpr int kTicksToExtrapolate = 3;

}  // namespace

HapticContact::HapticContact(double period, Part part)
    : period_(period),
      fade_(std::exp(-period / kFade)),
      lean_share_(1 - std::exp(-period / kLeans)),
      part_(part),
      patch_tissue_{Vector3d::Zero(), NoBranchStrains()} {}

void HapticContact::SetPatch(const ToolPatch& patch) noexcept {
  const bool same_organ = patch_ != nullptr && organ_ == patch.organ;
  started_ = started_ && same_organ;
  patch_ = &patch;
  organ_ = patch.organ;
  is_new_ = true;
  is_patch_new_ = true;
  if (!same_organ || !IsViscous()) memory_.known = false;
  if (memory_.known && !memory_of_grasp_) FindMemoryAgain();
  if (!touching_) return;
  if (!same_organ || !FindAgain()) {
    LoseContact();
    fades_out_ = true;
  }
}

// Finds the place of the contact on a new patch.
bool HapticContact::FindAgain() {
  on_far_ = !mesh_surface().Has(foot_.mesh_triangle) && !far_surface().empty() &&
            !mesh_surface().Covers(p_foot_W_) &&
            far_surface().Find(-1, foot_.weights, p_foot_W_, &foot_);
  return on_far_ || mesh_surface().Find(foot_.mesh_triangle, foot_.weights, p_foot_W_, &foot_);
}

void HapticContact::ClearPatch() noexcept {
  patch_ = nullptr;
  organ_ = -1;
  memory_.known = false;
  LoseContact();
}

void HapticContact::LoseContact() {
  touching_ = false;
  force_W_.setZero();
  moved_W_.setZero();
  friction_W_.setZero();
  lean_W_.setZero();
}

void HapticContact::Locate(TipPose tip) noexcept {
  result_ = {};
  in_lattice_ = began_beside_ = false;
  pushed_W_.setZero();
  held_W_.setZero();
  organ_offset_W_.setZero();
  if (organ_ >= 0) organ_offset_W_ = patch_->motion.Offset(tip.time_ns);
  tip.X_WT.translation() -= organ_offset_W_;
  if (part_ == Part::kShaft) MoveToShaft(&tip);
  step_ = {};
  if (IsViscous()) {
    const double elapsed = started_ ? ToSeconds(tip.time_ns - time_ns_) : 0;
    step_ = MaxwellStep(patch_->prony, elapsed > 0 ? elapsed : period_);
  }
  const bool holds = organ_ >= 0 && patch_->kind == ContactKind::kGrasp && tip.jaw <= kJawLetsGo;
  way_T_.setZero();
  if (!holds) {
    slip_T_.setZero();
    slip_length_ = 0;
  }
  if (memory_of_grasp_ && !holds) memory_.known = memory_of_grasp_ = false;
  if (organ_ < 0) {
    LoseContact();
  } else if (holds) {
    LoseContact();
    LocateGrasp(tip);
  } else {
    LocatePress(&tip);
  }
  time_ns_ = tip.time_ns;
  X_WT_last_ = tip.X_WT;
  p_tip_last_W_ = tip.X_WT.translation();
  result_.p_tip_organ_W = p_tip_last_W_;
  started_ = true;
}

HapticForce HapticContact::Evaluate(const TipPose& tip) noexcept {
  Locate(tip);
  Solve(this);
  return result_;
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
    const double others = tip_.normal_W.dot(moved_W_ - pushed_W_ + held_W_);
    result_.depth = std::max(tip_.depth + others, 0.0);
  }
  result_.slip = tip_.holds ? slip_length_ : 0;
  // Eq. 29 with delta = p_current - p_original, the latter displaced by the other tip's force. With
  // the springs C^-1 it returns -F up to rounding (engine/README.md, section 7, has the reason).
  const Matrix3d C_W = ComplianceAt(tip_, force_on_tissue_W);
  const Vector3d delta_W = C_W * force_on_tissue_W;
  result_.reaction_W = ForceOnHand(NodeOfCompliance(C_W), delta_W);
  result_.rigid = patch_->rigid;
  if (!result_.rigid) {
    result_.tissue_stored = TipEnergy(tip_, force_on_tissue_W);
    return;
  }
  result_.stored = 0.5 * force_on_tissue_W.dot(delta_W);
  result_.wall_W = result_.reaction_W;
}

// A patch that lasted for less than three ticks gives no extrapolation of the force, so there is
// nothing to fade in from. A contact without a place on the new patch fades out.
void HapticContact::FadeIn() {
  if (organ_ >= 0 && patch_->rigid) {
    offset_W_.setZero();
    fades_out_ = false;
    is_new_ = jumps_ = false;
    ticks_of_patch_ = 0;
    return;
  }
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
    // Extrapolates by the lesser of the last two changes, so a single jump is not extrapolated.
    const Vector3d last_W = raw_last_W_ - raw_before_W_, before_W = raw_before_W_ - raw_first_W_;
    offset_W_ += raw_last_W_ - raw_W;
    offset_W_ += before_W.squaredNorm() < last_W.squaredNorm() ? before_W : last_W;
  }
  if (jumps_ && (in_contact || fades_out_)) offset_W_ += raw_last_W_ - raw_W;
  jumps_ = false;
  raw_first_W_ = raw_before_W_;
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
  result_.tissue_stored *= felt_W.squaredNorm() / std::max(raw_W.squaredNorm(), 1e-300);
}

void HapticContact::Solve(HapticContact* tip) noexcept {
  tip->FindForce();
  tip->Apply();
}

void HapticContact::Solve(HapticContact* a, HapticContact* c) noexcept {
  FindForces(a, c);
  a->HoldBack(*c);
  c->HoldBack(*a);
  a->Apply();
  c->Apply();
}

// Makes the found force the tick's result.
void HapticContact::Apply() noexcept {
  KeepSlip();
  if (in_lattice_) {
    SetReaction(found_W_);
  } else {
    found_W_.setZero();
  }
  Remember(found_W_, moved_W_);
  FadeIn();
  if (part_ == Part::kShaft) CountAtTip();
}

void HapticContact::PushTo(const Vector3d& moved_W) noexcept {
  const Vector3d further_W = moved_W - pushed_W_;
  pushed_W_ = moved_W;
  tip_.p_original_W += further_W;
  tip_.depth += tip_.normal_W.dot(further_W);
}

Matrix3d HapticContact::CouplingTo(const HapticContact& other) const noexcept {
  if (organ_ != other.organ_) return Matrix3d::Zero();
  // Each foot's coupling assumes the other contact at its place in the step.
  const auto name_each_other = [&](PlaceId ToolPatch::*partner) {
    return patch_->*partner == other.patch_->id && other.patch_->*partner == patch_->id;
  };
  if (name_each_other(&ToolPatch::other)) {
    // The first tick of a grasp may have another stiffening than the other tip's.
    return coupling_W_ + other.coupling_W_.transpose() -
           patch_->coupling_W / std::sqrt(step_.stiffening * other.step_.stiffening);
  }
  if (touching_ && other.touching_ && name_each_other(&ToolPatch::beside)) {
    return (AtFoot(&PatchPoint::beside_W) + other.AtFoot(&PatchPoint::beside_W).transpose() -
            patch_->to_beside_W) /
           step_.stiffening;
  }
  const Matrix3d coupling_W = ConstantCouplingTo(other.patch_->id);
  if (!coupling_W.isZero(0)) return coupling_W;
  return other.ConstantCouplingTo(patch_->id).transpose();
}

Matrix3d HapticContact::ConstantCouplingTo(PlaceId place) const {
  for (int i = 0; i < patch_->coupling_count; ++i) {
    if (patch_->couplings[i].to == place) return patch_->couplings[i].compliance_W;
  }
  return Matrix3d::Zero();
}

void HapticContact::FindForce() noexcept {
  moved_W_ = pushed_W_;
  if (!in_lattice_) return;
  TakeSlipBack();
  SlipInJaws(WayInJaws(TipForce(tip_)));
  found_W_ = TipForce(tip_);
}

void HapticContact::FindForces(HapticContact* a, HapticContact* c) noexcept {
  if (!a->in_lattice_ || !c->in_lattice_ || a->organ_ != c->organ_) {
    a->FindForce();
    c->FindForce();
    return;
  }
  a->TakeSlipBack();
  c->TakeSlipBack();
  const Matrix3d coupling_W = a->CouplingTo(*c);
  Vector3d &force_a_W = a->found_W_, &force_c_W = c->found_W_;
  TipForces(a->tip_, c->tip_, coupling_W, &force_a_W, &force_c_W);
  const Vector3d way_a_T = a->WayInJaws(force_a_W), way_c_T = c->WayInJaws(force_c_W);
  if (!way_a_T.isZero(0) || !way_c_T.isZero(0)) {
    // Held by both, the tissue is stiffer: a part of the way may be enough.
    CondensedTip moved_a = a->tip_, moved_c = c->tip_;
    moved_a.p_current_W += a->R_WT_ * way_a_T;
    moved_c.p_current_W += c->R_WT_ * way_c_T;
    Vector3d after_a_W, after_c_W;
    TipForces(moved_a, moved_c, coupling_W, &after_a_W, &after_c_W);
    a->SlipInJaws(a->ShareOfWay(force_a_W, after_a_W) * way_a_T);
    c->SlipInJaws(c->ShareOfWay(force_c_W, after_c_W) * way_c_T);
    TipForces(a->tip_, c->tip_, coupling_W, &force_a_W, &force_c_W);
  }
  a->moved_W_ = coupling_W * force_c_W + a->pushed_W_;
  c->moved_W_ = coupling_W.transpose() * force_a_W + c->pushed_W_;
}

void HapticContact::HoldBack(const HapticContact& jaws) noexcept {
  if (!in_lattice_ || tip_.holds || !jaws.tip_.holds || jaws.organ_ != organ_) return;
  const Matrix3d coupling_W = CouplingTo(jaws);
  const Vector3d held_W =
      coupling_W * jaws.OwnCompliance().ldlt().solve(coupling_W.transpose() * found_W_);
  if (held_W.squaredNorm() > held_W_.squaredNorm()) held_W_ = held_W;
}

TickContactPoint HapticContact::contact_point() const noexcept {
  TickContactPoint contact_point;
  contact_point.known_organ = organ_;
  contact_point.slip_T = slip_T_;
  contact_point.from_trocar = from_trocar_;
  if (!touching_) return contact_point;
  contact_point.organ = organ_;
  contact_point.triangle = foot_.mesh_triangle;
  contact_point.weights = foot_.weights;
  contact_point.normal_W = tip_.normal_W;
  contact_point.friction_W = friction_W_;
  return contact_point;
}

}  // namespace hpdm
