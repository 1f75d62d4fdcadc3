#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/step/tool_geometry.h"
#include "haptics/contact/haptic_contact.h"

namespace hpdm {
namespace {

// m. Way along the surface over which its curvature is measured, and a radius that counts as flat.
constexpr double kRollProbe = 5e-4;
constexpr double kFlat = 1;

// m. A contact at a border, whose normals lie along the axis, rolls so far in a tick though the tool
// stands still.
constexpr double kBorderRoll = 5e-4;

// Searches along one tick's motion of a shaft.
constexpr int kMaxAdvances = 8;
constexpr double kShaftTouches = 1e-4;  // m, while it still moves

}  // namespace

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

// Finds where the shaft touches the patch, or did on its way from the last tick. The search sees the
// surface where other tools have moved it.
bool HapticContact::FindOnShaft(TipPose* tip) {
  at_border_ = false;
  const bool is_new = std::exchange(is_patch_new_, false);
  const bool has_last = std::exchange(axis_known_, true) && !is_new;
  const ShaftPart& part = patch_->shaft;
  const double from = std::max(part.from, apart_.from), radius = tip->tip_radius;
  const double to = std::min({part.to, apart_.to, end_});
  if (!(to > from) || !(radius > 0)) {
    axis_known_ = false;
    return false;
  }
  const std::array<Vector3d, 2> now_W{OnAxis(to) - by_tools_W_, OnAxis(from) - by_tools_W_};
  const std::array<Vector3d, 2> last_W = axis_last_W_;
  axis_last_W_ = now_W;
  moved_W_ = by_tools_W_;
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
  if (!touches) return FindInside(*tip) && faces();
  // A border may have normals along the axis, but a shaft that touches it from outside, between its
  // ends, is not end on.
  at_border_ = near.along > 0 && !faces();
  if (at_border_) longest_roll_ = tip->tip_radius;
  return at_border_ || faces();
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
  const Vector3d p_tip_W = tip.X_WT.translation() - by_tools_W_;
  return (mesh_surface().FindFoot(p_tip_W, tip.tip_radius, &foot_) && foot_.gap < tip.tip_radius) ||
         (!far_surface().empty() &&
          FindFarContact(p_tip_last_W_ - by_tools_W_, p_tip_W, tip.tip_radius, false));
}

// Moves the contact along the axis, on the shaft and on the surface, towards where the surface is
// parallel to the axis.
void HapticContact::Roll(TipPose* tip) {
  SurfaceFoot ahead = foot_;
  surface().Walk(kRollProbe * axis_W_, &ahead);
  const double way = (surface().Position(ahead) - surface().Position(foot_)).norm();
  const double turn = (ahead.normal_W - foot_.normal_W).dot(axis_W_);
  const double longest =
      std::abs(end_on_) > kMaxEndOn ? std::max(longest_roll_, kBorderRoll) : longest_roll_;
  double roll = std::copysign(longest, -end_on_);
  if (way > 0 && turn > way / kFlat) {
    roll = std::clamp(-end_on_ * way / turn, -longest, longest);
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

// Expresses the result of a shaft by the force and the way of the tip.
void HapticContact::CountAtTip() {
  const double lever = std::clamp(from_trocar_ / std::max(tip_from_trocar_, 1e-300), 0.0, 1.0);
  result_.reaction_W = OnTip(result_.reaction_W, axis_W_, lever);
  result_.wall_W = OnTip(result_.wall_W, axis_W_, lever);
  if (!(lever > 0)) return;
  const Vector3d p_tip_W = p_trocar_W_ + organ_offset_W_ - tip_from_trocar_ * axis_W_;
  result_.p_tip_organ_W = p_tip_W - OnTip(organ_offset_W_, axis_W_, 1 / lever);
}

}  // namespace hpdm
