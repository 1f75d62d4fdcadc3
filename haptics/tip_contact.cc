#include "haptics/tip_contact.h"

#include <algorithm>

#include "haptics/reaction_force.h"

namespace hpdm {

void TipContact::SetPatch(const ToolPatch& patch) noexcept {
  patch_ = &patch;
  surface_.Build(patch);
}

ContactResult TipContact::Evaluate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept {
  const bool grasps = patch_ != nullptr && patch_->kind == ContactKind::kGrasp && jaw <= kJawLetsGo;
  if (patch_ == nullptr || patch_->organ < 0 || grasps) surface_.Forget();
  if (patch_ == nullptr || patch_->organ < 0) return {};
  if (grasps) return EvaluateGrasp(X_WT);
  return EvaluatePress(X_WT.translation(), tip_radius);
}

ContactResult TipContact::EvaluatePress(const Vector3d& p_tip_W, double tip_radius) {
  SurfaceFoot foot;
  if (!surface_.FindFoot(p_tip_W, tip_radius, &foot)) return {};
  const double depth = tip_radius - foot.gap;
  if (!(depth > 0)) {
    surface_.Forget();
    return {};
  }

  ContactResult result;
  result.normal_W = foot.normal_W;
  result.depth = depth;
  result.organ = patch_->organ;
  result.kind = ContactKind::kPress;
  const Vector3d delta_W = -depth * foot.normal_W;
  for (int i = 0; i < 3; ++i) {
    result.reaction_W +=
        foot.weights[i] * ForceOnHand(patch_->points[foot.corners[i]].node, delta_W);
  }
  result.reaction_W -= std::min(result.reaction_W.dot(foot.normal_W), 0.0) * foot.normal_W;
  return result;
}

ContactResult TipContact::EvaluateGrasp(const Isometry3d& X_WT) const {
  ContactResult result;
  const Vector3d delta_W = X_WT * patch_->p_grasp_T - patch_->p_grasp_original_W;
  result.reaction_W = ForceOnHand(patch_->grasp_node, delta_W);
  result.organ = patch_->organ;
  result.kind = ContactKind::kGrasp;
  return result;
}

}  // namespace hpdm
