#include "haptics/tip_contact.h"

#include <algorithm>
#include <cmath>

#include "haptics/reaction_force.h"

namespace hpdm {
namespace {

// A foot is followed from the step's contact to the tip's place in the first tick of a patch: in
// stretches of 1 mm, over which it does not lose its way, as far as they go.
constexpr double kStretch = 0.001;  // m
constexpr int kMaxStretches = 10;

template <class Value>
Value AtFoot(const ToolPatch& patch, const std::array<std::uint8_t, 3>& corners,
             const Vector3d& weights, Value PatchPoint::*member) {
  return weights[0] * (patch.points[corners[0]].*member) +
         weights[1] * (patch.points[corners[1]].*member) +
         weights[2] * (patch.points[corners[2]].*member);
}

}  // namespace

void TipContact::SetPatch(const ToolPatch& patch) noexcept {
  patch_ = &patch;
  surface_.Build(patch);
  is_new_ = true;
  follows_ = false;
  p_offset_W_.setZero();
  normal_offset_W_.setZero();
  const int t = patch.contact_triangle;
  if (patch.reaction != ReactionType::kLattice || t < 0 || t >= patch.triangle_count) return;
  const auto& corners = patch.triangles[t];
  const Vector3d& weights = patch.contact_weights;
  const Vector3d p_W = AtFoot(patch, corners, weights, &PatchPoint::p_original_W);
  const Vector3d normal_W =
      AtFoot(patch, corners, weights, &PatchPoint::normal_W).stableNormalized();
  p_offset_W_ = patch.p_original_W - p_W;
  normal_offset_W_ = patch.normal_W - normal_W;
  if (!patch.pressed) return;
  follows_ = true;
  taken_back_W_ = p_W + patch.kernel_radius * normal_W - patch.p_tip_W;
  surface_.StartAt(corners, weights);
}

void TipContact::Locate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept {
  result_ = {};
  in_lattice_ = false;
  const bool grasps = patch_ != nullptr && patch_->kind == ContactKind::kGrasp && jaw <= kJawLetsGo;
  if (patch_ == nullptr || patch_->organ < 0 || grasps) surface_.Forget();
  if (patch_ == nullptr || patch_->organ < 0) return;
  if (grasps) {
    LocateGrasp(X_WT);
  } else {
    LocatePress(X_WT.translation(), tip_radius);
  }
  is_new_ = false;
}

ContactResult TipContact::Evaluate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept {
  Locate(X_WT, jaw, tip_radius);
  Solve(this);
  return result_;
}

void TipContact::LocatePress(const Vector3d& p_tip_W, double tip_radius) {
  if (patch_->reaction == ReactionType::kLattice) {
    LocateInLattice(p_tip_W, tip_radius);
  } else {
    PressPaper(p_tip_W, tip_radius);
  }
  if (result_.kind == ContactKind::kNone && !in_lattice_) LoseContact();
}

void TipContact::LoseContact() {
  surface_.Forget();
  follows_ = false;
}

void TipContact::LocateGrasp(const Isometry3d& X_WT) {
  const Vector3d p_W = X_WT * patch_->p_grasp_T;
  if (patch_->reaction == ReactionType::kPaper) {
    result_.organ = patch_->organ;
    result_.kind = ContactKind::kGrasp;
    result_.reaction_W = ForceOnHand(patch_->grasp_node, p_W - patch_->p_original_W);
    return;
  }
  result_.organ = patch_->organ;
  result_.kind = ContactKind::kGrasp;
  in_lattice_ = true;
  tip_ = {.holds = true,
          .p_original_W = patch_->p_original_W,
          .compliance_W = patch_->compliance_W,
          .p_current_W = p_W};
  coupling_W_ = patch_->coupling_W;
}

bool TipContact::FindFoot(const Vector3d& p_tip_W, double tip_radius, SurfaceFoot* foot) {
  if (!follows_) return surface_.FindFoot(p_tip_W, tip_radius + p_offset_W_.norm(), foot);
  // The depth decides whether it still touches, not the gap of the tip that is taken back.
  const double reach = tip_radius + taken_back_W_.norm() + p_offset_W_.norm();
  const Vector3d end_W = p_tip_W + taken_back_W_;
  if (is_new_) {
    const Vector3d start_W = patch_->p_tip_W + taken_back_W_;
    const Vector3d way = end_W - start_W;
    const int stretches = std::min(kMaxStretches, static_cast<int>(way.norm() / kStretch));
    for (int i = 1; i <= stretches; ++i) {
      if (!surface_.FindFoot(start_W + i / (stretches + 1.0) * way, reach, foot)) break;
    }
  }
  return surface_.FindFoot(end_W, reach, foot);
}

void TipContact::LocateInLattice(const Vector3d& p_tip_W, double tip_radius) {
  SurfaceFoot foot;
  if (!FindFoot(p_tip_W, tip_radius, &foot)) return;
  const Vector3d& w = foot.weights;
  LatticeTip tip;
  tip.p_original_W = AtFoot(*patch_, foot.corners, w, &PatchPoint::p_original_W) + p_offset_W_;
  tip.normal_W = (AtFoot(*patch_, foot.corners, w, &PatchPoint::normal_W).stableNormalized() +
                  normal_offset_W_)
                     .stableNormalized();
  tip.depth = tip.normal_W.dot(tip.p_original_W - p_tip_W) + tip_radius;
  tip.compliance_W = AtFoot(*patch_, foot.corners, w, &PatchPoint::compliance_W);
  in_lattice_ = true;
  tip_ = tip;
  coupling_W_ = AtFoot(*patch_, foot.corners, w, &PatchPoint::coupling_W);
}

void TipContact::PressPaper(const Vector3d& p_tip_W, double tip_radius) {
  SurfaceFoot foot;
  if (!surface_.FindFoot(p_tip_W, tip_radius, &foot)) return;
  const double depth = tip_radius - foot.gap;
  if (!(depth > 0)) return;
  result_.normal_W = foot.normal_W;
  result_.depth = depth;
  result_.organ = patch_->organ;
  result_.kind = ContactKind::kPress;
  const Vector3d delta_W = -depth * foot.normal_W;
  for (int i = 0; i < 3; ++i) {
    result_.reaction_W +=
        foot.weights[i] * ForceOnHand(patch_->points[foot.corners[i]].node, delta_W);
  }
  result_.reaction_W -= std::min(result_.reaction_W.dot(foot.normal_W), 0.0) * foot.normal_W;
}

void TipContact::Feel(const Vector3d& force_on_tissue_W) {
  if (!tip_.holds) {
    if (force_on_tissue_W.squaredNorm() == 0) {
      LoseContact();
      return;
    }
    result_.organ = patch_->organ;
    result_.kind = ContactKind::kPress;
    result_.normal_W = tip_.normal_W;
    result_.depth = std::max(tip_.depth, 0.0);
  }
  // Eq. 29 with delta = p_current - p_original, the latter as the other tip's force leaves it.
  const Vector3d delta_W = tip_.compliance_W * force_on_tissue_W;
  result_.reaction_W = ForceOnHand(NodeOfCompliance(tip_.compliance_W), delta_W);
}

void TipContact::Solve(TipContact* tip) noexcept {
  if (tip->in_lattice_) tip->Feel(TipForce(tip->tip_));
}

void TipContact::Solve(TipContact* a, TipContact* c) noexcept {
  if (!a->in_lattice_ || !c->in_lattice_ || a->patch_->organ != c->patch_->organ) {
    Solve(a);
    Solve(c);
    return;
  }
  // Each foot's coupling holds for the other tip where the step had it.
  const Matrix3d coupling_W = a->coupling_W_ + c->coupling_W_.transpose() - a->patch_->coupling_W;
  Vector3d force_a_W, force_c_W;
  TipForces(a->tip_, c->tip_, coupling_W, &force_a_W, &force_c_W);
  a->Feel(force_a_W);
  c->Feel(force_c_W);
}

}  // namespace hpdm
