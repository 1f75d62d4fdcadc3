#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "engine/step/tool_geometry.h"
#include "haptics/contact/haptic_contact.h"
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

// m. A contact that lags this far behind its tip has ended: the tip has left sideways. So has one
// this deep: tissue is nowhere as thick above a support.
constexpr double kLost = 0.05;
constexpr double kDeepest = 0.12;

// Largest cosine between a shaft's axis and the normal of a contact that lasts.
constexpr double kMaxEndOnLast = 0.95;

// m. A contact that lags this far behind its tip cannot slide there. It has ended if the tip is off the
// released surface.
constexpr double kStuck = 0.004;

// m. A contact that must slide this far beyond the mesh's triangles of the patch leaves them.
constexpr double kBeyondPatch = 0.001;

}  // namespace

void HapticContact::LocatePress(TipPose* given) {
  const bool was_touching = touching_;
  if (was_touching) lean_W_ += lean_share_ * (Lean() - lean_W_);
  const bool is_shaft = part_ == Part::kShaft;
  if (!was_touching && !(is_shaft ? FindOnShaft(given) : FindContact(*given))) return;
  touching_ = true;
  EvaluateAtFoot(*given);
  if (was_touching && !Slide(*given)) {
    LoseContact();
    return;
  }
  if (is_shaft) {
    axis_known_ = false;
    if (was_touching || at_border_) Roll(given);
    const bool begins_at_border = std::exchange(at_border_, false);
    if (!(end_ > 0) || std::abs(end_on_) > (begins_at_border ? kMaxEndOn : kMaxEndOnLast)) {
      LoseContact();
      return;
    }
  }
  const TipPose& tip = *given;
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
  const Vector3d p_tip_W = tip.X_WT.translation() - by_tools_W_;
  const Vector3d p_last_W = p_tip_last_W_ - by_tools_W_;
  const bool moved_far = started_ && (p_tip_W - p_last_W).norm() > kFarInATick;
  on_far_ = false;
  if (other_count_ > 0) return FindBeside(tip);
  const bool found =
      (moved_far && mesh_surface().FindEntry(p_last_W, p_tip_W, &foot_)) ||
      (mesh_surface().FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius) ||
      (!far_surface().empty() && FindFarContact(p_last_W, p_tip_W, tip.tip_radius, moved_far));
  if (found) moved_W_ = by_tools_W_;
  return found;
}

// The search sees the surface where the tip's other contacts have moved it.
bool HapticContact::FindBeside(const TipPose& tip) {
  const std::span others_W(others_W_.data(), other_count_);
  began_beside_ = !others_on_far_ &&
                  mesh_surface().FindBeside(tip.X_WT.translation() - by_others_W_ - by_tools_W_,
                                            tip.tip_radius, others_W, &foot_);
  if (!began_beside_) return false;
  moved_W_ = by_others_W_ + by_tools_W_;
  jumps_ = true;
  return true;
}

void HapticContact::StandBeside(std::span<const HapticContact> tips) noexcept {
  other_count_ = 0;
  others_on_far_ = false;
  by_others_W_.setZero();
  for (const HapticContact& other : tips) {
    if (&other == this || organ_ < 0 || other.organ_ != organ_ || !other.touching_) continue;
    others_W_[other_count_++] = other.foot_.normal_W;
    others_on_far_ = others_on_far_ || other.on_far_;
    by_others_W_ += ConstantCouplingTo(other.patch_->id) * other.force_W_;
  }
}

void HapticContact::StandOnMoved(std::span<const HapticContact> of_other_tool) noexcept {
  if (touching_ || organ_ < 0) return;
  for (const HapticContact& other : of_other_tool) {
    if (other.organ_ != organ_ || other.found_W_.isZero(0)) continue;
    by_tools_W_ += (patch_->other == other.patch_->id ? patch_->coupling_W
                                                      : ConstantCouplingTo(other.patch_->id)) *
                   other.found_W_;
  }
}

bool HapticContact::IsOneWith(const HapticContact& other) const noexcept {
  constexpr double kOneCosine = 0.94;
  return touching_ && other.touching_ && organ_ == other.organ_ &&
         foot_.normal_W.dot(other.foot_.normal_W) > kOneCosine;
}

void HapticContact::GiveUp() noexcept {
  LoseContact();
  in_lattice_ = false;
  fades_out_ = jumps_ = true;
}

// The coarse surface counts only where the patch has no triangles of the mesh.
bool HapticContact::FindFarContact(const Vector3d& p_last_W, const Vector3d& p_tip_W, double radius,
                                   bool moved_far) {
  on_far_ = (moved_far && far_surface().FindEntry(p_last_W, p_tip_W, &foot_)) ||
            (far_surface().FindFoot(p_tip_W, radius, &foot_) && foot_.gap < radius);
  on_far_ = on_far_ && !mesh_surface().Covers(far_surface().Position(foot_));
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
    if (IsViscous()) ApplyMemory();
  }
  if (part_ == Part::kShaft) {
    end_on_ = axis_W_.dot(tip_.normal_W);
    tip_.normal_W = (tip_.normal_W - end_on_ * axis_W_).stableNormalized();
  }
  if (patch_->rigid) tip_.compliance_W = WallAtFoot().Compliance(tip_.normal_W);
  tip_.depth = tip_.normal_W.dot(tip_.p_original_W - tip.X_WT.translation()) + tip.tip_radius;
}

WallStiffness HapticContact::WallAtFoot() const {
  WallStiffness wall;
  for (int k = 0; k < 3; ++k) {
    const WallStiffness& corner = surface_patch().points[foot_.corners[k]].wall;
    wall.normal += foot_.weights[k] * corner.normal;
    wall.tangential += foot_.weights[k] * corner.tangential;
  }
  return wall;
}

// Returns the lean of the normal that gives the work of friction on the indentation back. Its
// compliance q H is larger across the normal than along it, so F turns H as the place moves by ds
// over a curved surface, and does the work 1/2 q F . dH F besides what H stores. f_n lean . ds takes
// it back. The curvature jumps from triangle to triangle.
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
  const bool viscous = IsViscous();
  const Vector3d stands_W = foot_.normal_W + patch_->tilt_W + lean_W_;
  const Vector3d& force_W = viscous ? memory_.dent.equilibrium_force_W() : force_W_;
  const Vector3d& step_force_W = viscous ? patch_->equilibrium_force_W : patch_->force_on_tissue_W;
  const double pressing = -force_W.dot(foot_.normal_W);
  const Matrix3d turn = pressing * patch_->tilt_compliance_W;
  const Vector3d n = (Matrix3d::Identity() + turn).inverse() *
                     (stands_W - patch_->tilt_compliance_W * step_force_W + turn * friction_W_);
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
  } else if (!on_far_ && offset2 > kBeyondPatch * kBeyondPatch &&
             mesh_surface().IsOnBorder(foot_)) {
    LeavePatch(tip);
  }
  return !HasLeftSideways(tip) && tip_.depth < kDeepest;
}

// True if the tip has left the contact behind, as when a press that is deeper than an edge is round has
// slid off it.
bool HapticContact::HasLeftSideways(const TipPose& tip) const {
  const double lag2 = TangentialOffset(tip).squaredNorm();
  if (lag2 >= kLost * kLost) return true;
  if (on_far_ || lag2 < kStuck * kStuck) return false;
  return mesh_surface().IsOutside(tip.X_WT.translation() - moved_W_, tip.tip_radius);
}

// Moves a contact at the border to the coarse surface, if there is one that faces the same way. At a thin
// edge the nearest place may be on its other side.
void HapticContact::LeavePatch(const TipPose& tip) {
  SurfaceFoot far = foot_;
  if (!far_surface().Find(-1, foot_.weights, mesh_surface().Position(foot_), &far)) return;
  if (!(far.normal_W.dot(foot_.normal_W) > 0)) return;
  foot_ = far;
  on_far_ = true;
  jumps_ = true;
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
        foot_.weights[i] * ForceOnHand(surface_patch().nodes[foot_.corners[i]], delta_W);
  }
  result_.reaction_W -= std::min(result_.reaction_W.dot(tip_.normal_W), 0.0) * tip_.normal_W;
  result_.tissue_stored = 0.5 * tip_.depth * result_.reaction_W.norm();
}

}  // namespace hpdm
