#include "render/instrument/drawn_pose.h"

namespace hpdm {

Isometry3d DrawnPose(const ToolPose& tool, const SolvedContact& contact, double tip_radius) {
  Isometry3d X_WT = tool.X_WT;
  const bool presses = contact.rigid && contact.kind == ContactKind::kPress &&
                       contact.force_on_tissue_W.squaredNorm() > 0;
  if (!presses) return X_WT;
  const Vector3d p_drawn_W = contact.p_original_W + tip_radius * contact.normal_W;
  if (contact.normal_W.dot(p_drawn_W - X_WT.translation()) <= 0) return X_WT;
  const Vector3d shaft_W = tool.p_trocar_W - X_WT.translation();
  const Vector3d drawn_shaft_W = tool.p_trocar_W - p_drawn_W;
  X_WT.linear() =
      Eigen::Quaterniond::FromTwoVectors(shaft_W, drawn_shaft_W).toRotationMatrix() * X_WT.linear();
  X_WT.translation() = p_drawn_W;
  return X_WT;
}

}  // namespace hpdm
