#include "haptics/contact/haptic_contact.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/step/tool_geometry.h"
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

// Largest cosine between a shaft's axis and the normal of a contact that lasts.
constexpr double kMaxEndOnLast = 0.95;

// m. Way along the surface over which its curvature is measured, and a radius that counts as flat.
constexpr double kRollProbe = 5e-4;
constexpr double kFlat = 1;

// Searches along one tick's motion of a shaft.
constexpr int kMaxAdvances = 8;
constexpr double kShaftTouches = 1e-4;  // m, while it still moves

// s. A contact that has carried no force for so long takes up the memory of the newest patch, which
// knows of its end: two steps at 30 Hz, and the delay of a patch.
constexpr double kForgets = 0.15;

// m. A contact that must slide this far beyond the mesh's triangles of the patch leaves them.
constexpr double kBeyondPatch = 0.001;

}  // namespace

template <class Value>
Value HapticContact::At(const Place& place, Value PatchPoint::*member) const {
  const auto& points = place.on_far ? patch_->far.points : patch_->points;
  const SurfaceFoot& foot = place.foot;
  return foot.weights[0] * (points[foot.corners[0]].*member) +
         foot.weights[1] * (points[foot.corners[1]].*member) +
         foot.weights[2] * (points[foot.corners[2]].*member);
}

HapticContact::HapticContact(double period, Part part)
    : period_(period),
      fade_(std::exp(-period / kFade)),
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
}

void HapticContact::Locate(TipPose tip) noexcept {
  result_ = {};
  in_lattice_ = false;
  pushed_W_.setZero();
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

void HapticContact::LocateGrasp(const TipPose& tip) {
  R_WT_ = tip.X_WT.linear();
  result_.organ = organ_;
  result_.kind = ContactKind::kGrasp;
  if (patch_->reaction == ReactionType::kPaper) {
    const Vector3d p_W = tip.X_WT * (patch_->p_grasp_T + slip_T_ - patch_->slip_T);
    result_.reaction_W = ForceOnHand(patch_->grasp_node, p_W - patch_->p_original_W);
    return;
  }
  in_lattice_ = true;
  tip_ = {.holds = true,
          .p_original_W = patch_->p_original_W,
          .compliance_W = patch_->compliance_W,
          .p_current_W = HeldPoint(tip.X_WT)};
  coupling_W_ = patch_->coupling_W;
  if (!IsViscous()) return;
  if (!memory_.known || !memory_of_grasp_) {
    memory_ = {};
    memory_.known = memory_of_grasp_ = true;
    memory_.tissue = {patch_->contact_W - patch_->series_W * patch_->force_on_tissue_W,
                      patch_->branches_W};
    step_ = MaxwellStep(patch_->prony, std::max(period_, ToSeconds(tip.time_ns - patch_->time_ns)));
  } else if (is_new_) {  // the same tissue, as the new patch describes it
    memory_.tissue.at = HeldPoint(X_WT_last_) - patch_->series_W * force_on_held_W_;
  }
  Vector3d memory_W;
  memory_.tissue.Memory(step_, tip_.p_original_W, &memory_W);
  tip_.p_original_W -= memory_W / step_.stiffening;
  tip_.compliance_W = ComplianceOfTick();
  coupling_W_ /= step_.stiffening;
}

// Returns the compliance of viscoelastic tissue to a force of this tick, with the part in series.
Matrix3d HapticContact::ComplianceOfTick() const {
  return (tip_.compliance_W + (step_.stiffening - 1) * patch_->series_W) / step_.stiffening;
}

// Returns the point that jaws at this pose hold, moved as their turn since the step acts.
Vector3d HapticContact::HeldPoint(const Isometry3d& X_WT) const {
  const Eigen::AngleAxisd turned(Matrix3d(X_WT.linear() * patch_->R_WT.transpose()));
  return X_WT * (patch_->p_grasp_T + slip_T_ - patch_->slip_T) +
         patch_->turn_W * (turned.angle() * turned.axis());
}

double HapticContact::DistanceTo(const ToolPatch& patch) const noexcept {
  constexpr double kOtherOrgan = 10;
  if (!touching_) return 0;
  return patch.organ == organ_ ? std::abs(patch.shaft.near - from_trocar_) : kOtherOrgan;
}

void HapticContact::KeepApartFrom(const HapticContact& other) noexcept {
  apart_ = {-1e300, 1e300};
  if (organ_ < 0 || organ_ != other.organ_ || !other.touching_) return;
  const double near = touching_ ? from_trocar_ : patch_->shaft.near;
  if (near < other.from_trocar_) {
    apart_.to = other.from_trocar_ - kShaftApart;
  } else {
    apart_.from = other.from_trocar_ + kShaftApart;
  }
}

// Puts the origin of the tool frame where the shaft presses, or did last.
void HapticContact::MoveToShaft(TipPose* tip) {
  const Vector3d p_tool_W = tip->X_WT.translation();
  axis_W_ = tip->X_WT.linear().col(2);
  p_trocar_W_ = p_tool_W + tip->from_trocar * axis_W_;
  end_ = tip->from_trocar - tip->tip_part;
  if (touching_) from_trocar_ = std::min(from_trocar_ + tip->from_trocar - tip_from_trocar_, end_);
  tip->X_WT.translation() = OnAxis(from_trocar_);
  longest_roll_ = std::max((p_tool_W - p_tool_last_W_).norm(),
                           (tip->X_WT.translation() - p_tip_last_W_).norm());
  tip_from_trocar_ = tip->from_trocar;
  p_tool_last_W_ = p_tool_W;
  tip->tip_radius = tip->shaft_radius;
}

void HapticContact::LocatePress(TipPose* given) {
  const bool was_touching = touching_;
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
    if (was_touching) Roll(given);
    if (!(end_ > 0) || std::abs(end_on_) > kMaxEndOnLast) {
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
  const Vector3d& p_tip_W = tip.X_WT.translation();
  const bool moved_far = started_ && (p_tip_W - p_tip_last_W_).norm() > kFarInATick;
  on_far_ = false;
  if (moved_far && mesh_surface().FindEntry(p_tip_last_W_, p_tip_W, &foot_)) return true;
  if (mesh_surface().FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius)
    return true;
  return !far_surface().empty() && FindFarContact(tip, moved_far);
}

// The coarse surface counts only where the patch has no triangles of the mesh.
bool HapticContact::FindFarContact(const TipPose& tip, bool moved_far) {
  const Vector3d& p_tip_W = tip.X_WT.translation();
  on_far_ = (moved_far && far_surface().FindEntry(p_tip_last_W_, p_tip_W, &foot_)) ||
            (far_surface().FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius);
  on_far_ = on_far_ && !mesh_surface().Covers(far_surface().Position(foot_));
  return on_far_;
}

// Finds where the shaft touches the patch, or did on its way from the last tick.
bool HapticContact::FindOnShaft(TipPose* tip) {
  const bool is_new = std::exchange(is_patch_new_, false);
  const bool has_last = std::exchange(axis_known_, true) && !is_new;
  const ShaftPart& part = patch_->shaft;
  const double from = std::max(part.from, apart_.from), radius = tip->tip_radius;
  const double to = std::min({part.to, apart_.to, end_});
  if (!(to > from) || !(radius > 0)) {
    axis_known_ = false;
    return false;
  }
  const std::array<Vector3d, 2> now_W{OnAxis(to), OnAxis(from)}, last_W = axis_last_W_;
  axis_last_W_ = now_W;
  const auto faces = [&] { return std::abs(foot_.normal_W.dot(axis_W_)) <= kMaxEndOn; };
  if (is_new) {
    from_trocar_ = std::clamp(part.near, from, to);
    tip->X_WT.translation() = OnAxis(from_trocar_);
    if (FindInside(*tip)) return faces();
  }
  double way = 0, share = 1;
  if (has_last) {
    way = std::max((now_W[0] - last_W[0]).norm(), (now_W[1] - last_W[1]).norm());
    clearance_ -= way;
    if (clearance_ > 0) return false;
    if (way > 0) share = 0;
  }
  SegmentFoot near;
  clearance_ = 0;
  bool touches = false, inside = false;
  for (int i = 0; i < kMaxAdvances && !touches && !inside; ++i) {
    const auto at = [&](int end) {
      return Vector3d(share == 1 ? now_W[end] : last_W[end] + share * (now_W[end] - last_W[end]));
    };
    if (!FindNearest(at(0), at(1), &near)) return false;
    touches = near.outside && near.distance <= radius + (share < 1 ? kShaftTouches : 0);
    inside = !near.outside;
    if (touches || inside) break;
    if (share == 1) {
      clearance_ = near.distance - radius;
      return false;
    }
    share = std::min(1.0, share + (near.distance - radius) / way);
  }
  if (touches) {
    foot_ = near.foot;
    from_trocar_ = to + near.along * (from - to);
  } else {
    from_trocar_ = std::clamp(from_trocar_, from, to);
  }
  tip->X_WT.translation() = OnAxis(from_trocar_);
  return (touches || FindInside(*tip)) && faces();
}

// Finds the place of the patch that is nearest to a segment. The coarse surface counts only where
// the patch has no triangles of the mesh.
bool HapticContact::FindNearest(const Vector3d& start_W, const Vector3d& end_W, SegmentFoot* near) {
  SegmentFoot far;
  const bool on_mesh = mesh_surface().FindNearest(start_W, end_W, near);
  const bool on_far = !far_surface().empty() && far_surface().FindNearest(start_W, end_W, &far) &&
                      !mesh_surface().Covers(far_surface().Position(far.foot));
  on_far_ = on_far && (!on_mesh || far.distance < near->distance);
  if (on_far_) *near = far;
  return on_mesh || on_far;
}

// Finds the foot of a shaft that has got into the surface unseen.
bool HapticContact::FindInside(const TipPose& tip) {
  on_far_ = false;
  return (mesh_surface().FindFoot(tip.X_WT.translation(), tip.tip_radius, &foot_) &&
          foot_.gap < tip.tip_radius) ||
         (!far_surface().empty() && FindFarContact(tip, false));
}

// Moves the contact along the axis, on the shaft and on the surface, towards where the surface is
// parallel to the axis.
void HapticContact::Roll(TipPose* tip) {
  SurfaceFoot ahead = foot_;
  surface().Walk(kRollProbe * axis_W_, &ahead);
  const double way = (surface().Position(ahead) - surface().Position(foot_)).norm();
  const double turn = (ahead.normal_W - foot_.normal_W).dot(axis_W_);
  double roll = std::copysign(longest_roll_, -end_on_);
  if (way > 0 && turn > way / kFlat) {
    roll = std::clamp(-end_on_ * way / turn, -longest_roll_, longest_roll_);
  }
  const double last = std::min(std::max(apart_.to, from_trocar_), end_);
  const double first = std::min({std::max(apart_.from, 0.0), from_trocar_, last});
  const double next = std::clamp(from_trocar_ - roll, first, last);
  roll = from_trocar_ - next;
  if (roll == 0) return;
  from_trocar_ = next;
  tip->X_WT.translation() = OnAxis(from_trocar_);
  surface().Walk(roll * axis_W_, &foot_);
  EvaluateAtFoot(*tip);
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

bool HapticContact::IsViscous() const {
  return organ_ >= 0 && patch_->prony.count > 0 && patch_->reaction == ReactionType::kLattice;
}

Vector3d HapticContact::PositionOf(const Place& place) const {
  return (place.on_far ? far_surface() : mesh_surface()).Position(place.foot);
}

// Returns how far the curved surface lies outside of its flat triangle, m.
Vector3d HapticContact::OffsetOf(const Place& place) const {
  return (place.on_far ? far_surface() : mesh_surface()).Offset(place.foot);
}

// Returns the tissue as the patch's step left it, held in place since then.
MaxwellState<Vector3d> HapticContact::TissueOfPatch(const Place& place) const {
  MaxwellState<Vector3d> tissue{At(place, &PatchPoint::tissue_W) + OffsetOf(place),
                                NoBranchStrains()};
  const auto& points = place.on_far ? patch_->far.points : patch_->points;
  const double age = std::max(0.0, ToSeconds(time_ns_ - patch_->time_ns));
  for (int i = 0; i < patch_->prony.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    for (int j = 0; j < 3; ++j) {
      tissue.branches[k] += place.foot.weights[j] *
                            points[place.foot.corners[static_cast<std::size_t>(j)]].branches_W[k];
    }
    tissue.branches[k] *= std::exp(-age / patch_->prony.terms[k].time);
  }
  return tissue;
}

HapticContact::Memory HapticContact::MemoryAtFoot() const {
  const Place here{on_far_, foot_};
  if (!memory_.known || memory_of_grasp_) return {true, TissueOfPatch(here), {}};
  const double way = (PositionOf(here) - p_memory_W_).norm();
  if (way == 0) return memory_;
  Memory memory{true, TissueOfPatch(here), memory_.dent};
  const double kept = std::exp(-way / patch_->indentation.resolved_radius());
  memory.tissue.at += kept * (memory_.tissue.at - patch_tissue_.at);
  for (std::size_t k = 0; k < memory.tissue.branches.size(); ++k) {
    memory.tissue.branches[k] += kept * (memory_.tissue.branches[k] - patch_tissue_.branches[k]);
  }
  memory.dent.Slide(way, patch_->indentation.radius());
  return memory;
}

// Finds the remembered tissue on a new patch.
void HapticContact::FindMemoryAgain() {
  SurfaceFoot& foot = memory_place_.foot;
  const Vector3d weights = foot.weights;
  memory_place_.on_far = !mesh_surface().Has(foot.mesh_triangle) && !far_surface().empty() &&
                         !mesh_surface().Covers(p_memory_W_) &&
                         far_surface().Find(-1, weights, p_memory_W_, &foot);
  memory_.known =
      memory_place_.on_far || mesh_surface().Find(foot.mesh_triangle, weights, p_memory_W_, &foot);
  if (!memory_.known) return;
  p_memory_W_ = PositionOf(memory_place_);
  patch_tissue_ = TissueOfPatch(memory_place_);
}

// Sets what the tissue at the foot shows to a force of this tick.
void HapticContact::ApplyMemory() {
  present_ = MemoryAtFoot();
  Vector3d memory_W, dent_W;
  present_.tissue.Memory(step_, tip_.p_original_W, &memory_W);
  p_free_W_ = tip_.p_original_W - memory_W / step_.stiffening;
  tip_.indentation = present_.dent.Law(patch_->indentation, step_, &dent_W);
  tip_.p_original_W = p_free_W_ + dent_W;
  tip_.compliance_W = ComplianceOfTick();
  coupling_W_ /= step_.stiffening;
}

// Ends the tick of viscoelastic tissue. `moved_W`: displacement by the other tip, m.
void HapticContact::Remember(const Vector3d& force_on_tissue_W, const Vector3d& moved_W) {
  if (!IsViscous()) return;
  if (!in_lattice_) {
    if (memory_.known) Recover();
    return;
  }
  if (tip_.holds) {
    force_on_held_W_ = force_on_tissue_W;
    memory_.tissue.Advance(step_, tip_.p_current_W - patch_->series_W * force_on_tissue_W);
    return;
  }
  unpressed_ = force_on_tissue_W.squaredNorm() > 0 || !memory_.known ? 0 : unpressed_ + period_;
  memory_ = present_;
  const Matrix3d of_tissue_W = tip_.compliance_W - patch_->series_W;
  memory_.tissue.Advance(step_, p_free_W_ + of_tissue_W * force_on_tissue_W + moved_W);
  memory_.dent.Advance(step_, force_on_tissue_W);
  memory_.known = unpressed_ < kForgets;
  memory_place_ = {on_far_, foot_};
  p_memory_W_ = PositionOf(memory_place_);
  patch_tissue_ = TissueOfPatch(memory_place_);
}

// The tissue where the tip has been returns by itself.
void HapticContact::Recover() {
  unpressed_ += period_;
  memory_.known = unpressed_ < kForgets;
  const Vector3d p_inf_W = At(memory_place_, &PatchPoint::p_original_W) + OffsetOf(memory_place_);
  Vector3d memory_W;
  memory_.tissue.Memory(step_, p_inf_W, &memory_W);
  memory_.tissue.Advance(step_, p_inf_W - memory_W / step_.stiffening);
  memory_.dent.Advance(step_, Vector3d::Zero());
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
  const bool viscous = IsViscous();
  const Vector3d stands_W = foot_.normal_W + patch_->tilt_W + Lean();
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
  return TangentialOffset(tip).squaredNorm() < kLost * kLost && tip_.depth < kDeepest;
}

// Moves a contact at the border to the coarse surface, if there is one.
void HapticContact::LeavePatch(const TipPose& tip) {
  on_far_ = far_surface().Find(-1, foot_.weights, mesh_surface().Position(foot_), &foot_);
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
    result_.reaction_W +=
        foot_.weights[i] * ForceOnHand(surface_patch().nodes[foot_.corners[i]], delta_W);
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
  if (organ_ >= 0 && patch_->rigid) {
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
  tip->FindForce();
  tip->Apply();
}

void HapticContact::Solve(HapticContact* a, HapticContact* c) noexcept {
  FindForces(a, c);
  a->Apply();
  c->Apply();
}

// Makes the found force the tick's result.
void HapticContact::Apply() noexcept {
  if (in_lattice_) {
    SetReaction(found_W_);
  } else {
    found_W_.setZero();
  }
  Remember(found_W_, moved_W_);
  FadeIn();
  if (part_ == Part::kShaft) CountAtTip();
}

// Expresses the result of a shaft by the force and the way of the tip.
void HapticContact::CountAtTip() {
  const double lever = std::clamp(from_trocar_ / std::max(tip_from_trocar_, 1e-300), 0.0, 1.0);
  result_.reaction_W = OnTip(result_.reaction_W, axis_W_, lever);
  if (!(lever > 0)) return;
  const Vector3d p_tip_W = p_trocar_W_ + organ_offset_W_ - tip_from_trocar_ * axis_W_;
  result_.p_tip_organ_W = p_tip_W - OnTip(organ_offset_W_, axis_W_, 1 / lever);
}

void HapticContact::PushTo(const Vector3d& moved_W) noexcept {
  const Vector3d further_W = moved_W - pushed_W_;
  pushed_W_ = moved_W;
  tip_.p_original_W += further_W;
  tip_.depth += tip_.normal_W.dot(further_W);
}

Matrix3d HapticContact::CouplingTo(int tool, int place) const noexcept {
  for (int i = 0; part_ == Part::kShaft && i < patch_->coupling_count; ++i) {
    const PlaceCoupling& coupling = patch_->couplings[i];
    if (coupling.tool == tool && coupling.place == place) return coupling.compliance_W;
  }
  return Matrix3d::Zero();
}

void HapticContact::FindForce() noexcept {
  moved_W_ = pushed_W_;
  if (!in_lattice_) return;
  SlipInJaws(WayInJaws(TipForce(tip_)));
  found_W_ = TipForce(tip_);
}

void HapticContact::FindForces(HapticContact* a, HapticContact* c) noexcept {
  if (!a->in_lattice_ || !c->in_lattice_ || a->organ_ != c->organ_) {
    a->FindForce();
    c->FindForce();
    return;
  }
  // Each foot's coupling assumes the other tip at its place in the step.
  // The first tick of a grasp may have another stiffening than the other tip's.
  const Matrix3d coupling_W =
      a->coupling_W_ + c->coupling_W_.transpose() -
      a->patch_->coupling_W / std::sqrt(a->step_.stiffening * c->step_.stiffening);
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
