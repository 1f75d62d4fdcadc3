#include "haptics/contact/haptic_contact.h"

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

// m. A contact that lags this far behind its tip has ended: the tip has left sideways. So has one
// this deep: tissue is nowhere as thick above a support.
constexpr double kLost = 0.05;
constexpr double kDeepest = 0.12;

// m. A contact that must slide this far beyond the mesh's triangles of the patch leaves them.
constexpr double kBeyondPatch = 0.001;

}  // namespace

template <class Value>
Value HapticContact::AtFoot(Value PatchPoint::*member) const {
  return foot_.weights[0] * (points()[foot_.corners[0]].*member) +
         foot_.weights[1] * (points()[foot_.corners[1]].*member) +
         foot_.weights[2] * (points()[foot_.corners[2]].*member);
}

HapticContact::HapticContact(double period) : fade_(std::exp(-period / kFade)) {}

void HapticContact::SetPatch(const ToolPatch& patch) noexcept {
  const bool same_organ = patch_ != nullptr && organ_ == patch.organ;
  started_ = started_ && same_organ;
  patch_ = &patch;
  organ_ = patch.organ;
  surface_.Build(patch);
  far_surface_.Build(patch.far);
  is_new_ = true;
  if (!touching_) return;
  if (!same_organ || !FindAgain()) {
    LoseContact();
    fades_out_ = true;
  }
}

// Finds the place of the contact on a new patch.
bool HapticContact::FindAgain() {
  on_far_ = !surface_.Has(foot_.mesh_triangle) && !far_surface_.empty() &&
            !surface_.Covers(p_foot_W_) && far_surface_.Find(-1, foot_.weights, p_foot_W_, &foot_);
  return on_far_ || surface_.Find(foot_.mesh_triangle, foot_.weights, p_foot_W_, &foot_);
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
  const bool holds = organ_ >= 0 && patch_->kind == ContactKind::kGrasp && tip.jaw <= kJawLetsGo;
  if (!holds) {
    slip_T_.setZero();
    slip_length_ = 0;
  }
  if (organ_ < 0) {
    LoseContact();
  } else if (holds) {
    LoseContact();
    LocateGrasp(tip);
  } else {
    LocatePress(tip);
  }
  p_tip_last_W_ = tip.X_WT.translation();
  result_.p_tip_organ_W = p_tip_last_W_;
  started_ = true;
}

HapticForce HapticContact::Evaluate(const TipPose& tip) noexcept {
  Locate(tip);
  Solve(this);
  return result_;
}

void HapticContact::LocateGrasp(const TipPose& tip) {
  R_WT_ = tip.X_WT.linear();
  Vector3d p_W = tip.X_WT * (patch_->p_grasp_T + slip_T_ - patch_->slip_T);
  result_.organ = organ_;
  result_.kind = ContactKind::kGrasp;
  if (patch_->reaction == ReactionType::kPaper) {
    result_.reaction_W = ForceOnHand(patch_->grasp_node, p_W - patch_->p_original_W);
    return;
  }
  const Eigen::AngleAxisd turned(Matrix3d(R_WT_ * patch_->R_WT.transpose()));
  p_W += patch_->turn_W * (turned.angle() * turned.axis());
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
  if (was_touching && !Slide(tip)) {
    LoseContact();
    return;
  }
  p_foot_W_ = surface().Position(foot_);
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
  const bool moved_far = started_ && (p_tip_W - p_tip_last_W_).norm() > kFarInATick;
  on_far_ = false;
  if (moved_far && surface_.FindEntry(p_tip_last_W_, p_tip_W, &foot_)) return true;
  if (surface_.FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius) return true;
  return !far_surface_.empty() && FindFarContact(tip, moved_far);
}

// The coarse surface counts only where the patch has no triangles of the mesh.
bool HapticContact::FindFarContact(const TipPose& tip, bool moved_far) {
  const Vector3d& p_tip_W = tip.X_WT.translation();
  on_far_ = (moved_far && far_surface_.FindEntry(p_tip_last_W_, p_tip_W, &foot_)) ||
            (far_surface_.FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius);
  on_far_ = on_far_ && !surface_.Covers(far_surface_.Position(foot_));
  return on_far_;
}

void HapticContact::EvaluateAtFoot(const TipPose& tip) {
  tip_ = {};
  tip_.p_original_W = AtFoot(&PatchPoint::p_original_W) + surface().Offset(foot_);
  tip_.normal_W = foot_.normal_W;
  if (patch_->reaction == ReactionType::kLattice) {
    tip_.normal_W = PressedNormal();
    tip_.compliance_W = AtFoot(&PatchPoint::compliance_W);
    tip_.indentation = patch_->indentation;
    coupling_W_ = AtFoot(&PatchPoint::coupling_W);
  }
  if (patch_->rigid) tip_.compliance_W = WallAtFoot().Compliance(tip_.normal_W);
  tip_.depth = tip_.normal_W.dot(tip_.p_original_W - tip.X_WT.translation()) + tip.tip_radius;
}

WallStiffness HapticContact::WallAtFoot() const {
  WallStiffness wall;
  for (int k = 0; k < 3; ++k) {
    const WallStiffness& corner = points()[foot_.corners[k]].wall;
    wall.normal += foot_.weights[k] * corner.normal;
    wall.tangential += foot_.weights[k] * corner.tangential;
  }
  return wall;
}

// Returns the lean of the normal that gives the work of friction on the indentation back. Its
// compliance q H is larger across the normal than along it, so F turns H as the place moves by ds
// over a curved surface, and does the work 1/2 q F . dH F = -f_n lean . ds besides what H stores.
Vector3d HapticContact::Lean() const {
  const LocalIndentation& indentation = patch_->indentation;
  if (friction_W_.isZero(0) || !indentation.indents() || patch_->rigid) return Vector3d::Zero();
  const Vector3d& n = foot_.normal_W;
  const double pressing = std::max(0.0, -force_W_.dot(n));
  const Vector3d across_W = pressing * friction_W_;
  const Matrix3d& H = indentation.factor_W();
  return indentation.BallYield(pressing) *
         surface().Turn(foot_, H * across_W - n.dot(H * n) * across_W);
}

// Uses the f_n of the last tick but the direction of the normal to be found. With both from the
// last tick they would oscillate.
Vector3d HapticContact::PressedNormal() const {
  const Vector3d stands_W = foot_.normal_W + patch_->tilt_W + Lean();
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
  const Vector3d hold_W = HoldingForce(tip_, target_W - tip_.p_original_W - moved_W_);
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
    const Vector3d force_W = TipForce(moved);
    offset_W -= ComplianceAt(moved, force_W) * force_W;
  }
  return offset_W - n.dot(offset_W) * n;
}

// Moves the contact along the surface. False if the tip has left it behind.
bool HapticContact::Slide(const TipPose& tip) {
  if (Sticks(tip)) return true;
  const Vector3d tangential_W = TangentialOffset(tip);
  const Vector3d way_W = tip.X_WT.translation() - p_tip_last_W_;
  const double against = tip_.normal_W.dot(way_W);
  const double longest =
      kSlipAlong * (way_W - against * tip_.normal_W).norm() + kSlipAgainst * std::abs(against);
  const SurfaceFoot before = foot_;
  surface().Walk(std::min(1.0, longest / std::max(tangential_W.norm(), 1e-300)) * tangential_W,
                 &foot_);
  EvaluateAtFoot(tip);
  const double offset2 = TangentialOffset(tip).squaredNorm();
  if (offset2 > tangential_W.squaredNorm()) {
    foot_ = before;
    EvaluateAtFoot(tip);
  } else if (!on_far_ && offset2 > kBeyondPatch * kBeyondPatch && surface_.IsOnBorder(foot_)) {
    LeavePatch(tip);
  }
  return TangentialOffset(tip).squaredNorm() < kLost * kLost && tip_.depth < kDeepest;
}

// Moves a contact at the border to the coarse surface, if there is one.
void HapticContact::LeavePatch(const TipPose& tip) {
  on_far_ = far_surface_.Find(-1, foot_.weights, surface_.Position(foot_), &foot_);
  if (!on_far_) return;
  left_patch_ = true;
  EvaluateAtFoot(tip);
}

void HapticContact::PressPaper() {
  result_.normal_W = tip_.normal_W;
  result_.depth = tip_.depth;
  result_.organ = organ_;
  result_.kind = ContactKind::kPress;
  const Vector3d delta_W = -tip_.depth * tip_.normal_W;
  for (int i = 0; i < 3; ++i) {
    result_.reaction_W += foot_.weights[i] * ForceOnHand(points()[foot_.corners[i]].node, delta_W);
  }
  result_.reaction_W -= std::min(result_.reaction_W.dot(tip_.normal_W), 0.0) * tip_.normal_W;
}

// Returns the part of a force along the jaws' faces, tool frame.
Vector3d HapticContact::AlongFaces(const Vector3d& force_W) const {
  return (R_WT_.transpose() * force_W).cwiseProduct(Vector3d(0, 1, 1));
}

// Returns the way of the held point along the faces (tool frame, m) after which friction can hold
// the rest of this tip's force, if the other tip does nothing.
Vector3d HapticContact::WayInJaws(const Vector3d& force_on_tissue_W) const {
  const Vector3d along_T = AlongFaces(force_on_tissue_W);
  const double pull = along_T.norm();
  if (!tip_.holds || !(pull > patch_->hold)) return Vector3d::Zero();
  const Matrix3d S_T = R_WT_.transpose() * tip_.compliance_W.inverse() * R_WT_;
  const Vector3d excess_T = (1 - patch_->hold / pull) * along_T;
  Vector3d way_T = Vector3d::Zero();
  way_T.tail<2>() = -S_T.bottomRightCorner<2, 2>().inverse() * excess_T.tail<2>();
  return way_T.allFinite() ? way_T : Vector3d::Zero();
}

// Returns the share of a way after which the pull has fallen to what friction holds. The law is
// linear: `before` and `after` are the forces without the way and after all of it.
double HapticContact::ShareOfWay(const Vector3d& before_W, const Vector3d& after_W) const {
  const Vector3d along_T = AlongFaces(before_W);
  const double pull = along_T.norm();
  const double fallen = pull - along_T.dot(AlongFaces(after_W)) / std::max(pull, 1e-300);
  return fallen > 0 ? std::clamp((pull - patch_->hold) / fallen, 0.0, 1.0) : 0;
}

void HapticContact::SlipInJaws(const Vector3d& way_T) {
  slip_T_ += way_T;
  slip_length_ += way_T.norm();
  tip_.p_current_W += R_WT_ * way_T;
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
  result_.slip = tip_.holds ? slip_length_ : 0;
  // Eq. 29 with delta = p_current - p_original, the latter displaced by the other tip's force. With
  // the springs C^-1 it returns -F up to rounding (engine/README.md, section 7, has the reason).
  const Matrix3d C_W = ComplianceAt(tip_, force_on_tissue_W);
  const Vector3d delta_W = C_W * force_on_tissue_W;
  result_.reaction_W = ForceOnHand(NodeOfCompliance(C_W), delta_W);
  result_.rigid = patch_->rigid;
  if (!result_.rigid) return;
  result_.stored = 0.5 * force_on_tissue_W.dot(delta_W);
  result_.wall_W = result_.reaction_W;
}

// A patch that lasted for less than three ticks gives no extrapolation of the force, so there is
// nothing to fade in from. A contact without a place on the new patch fades out.
void HapticContact::FadeIn() {
  if (patch_ != nullptr && patch_->rigid) {
    offset_W_.setZero();
    fades_out_ = false;
    is_new_ = false;
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
  if (left_patch_ && in_contact) offset_W_ += raw_last_W_ - raw_W;
  left_patch_ = false;
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
}

void HapticContact::Solve(HapticContact* tip) noexcept {
  tip->moved_W_.setZero();
  if (tip->in_lattice_) {
    tip->SlipInJaws(tip->WayInJaws(TipForce(tip->tip_)));
    tip->SetReaction(TipForce(tip->tip_));
  }
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
  contact_point.slip_T = slip_T_;
  if (!touching_) return contact_point;
  contact_point.organ = organ_;
  contact_point.triangle = foot_.mesh_triangle;
  contact_point.weights = foot_.weights;
  contact_point.normal_W = tip_.normal_W;
  contact_point.friction_W = friction_W_;
  return contact_point;
}

}  // namespace hpdm
