#pragma once

#include "engine/snapshots.h"
#include "haptics/patch_surface.h"

namespace hpdm {

/// What one tool feels in one tick.
struct ContactResult {
  Vector3d reaction_W = Vector3d::Zero();  ///< Eq. 29's force on the hand, N.
  Vector3d normal_W = Vector3d::Zero();    ///< Press: the outward unit normal; else zero.
  double depth = 0;                        ///< Press: of the tip below the released surface, m.
  int organ = -1;
  ContactKind kind = ContactKind::kNone;
};

/// Eq. 29 between two deformation steps, against the newest patch of one tool.
///
/// Press: with the tip's foot on the released surface (patch_surface.h), depth = tip_radius - gap.
/// When it is positive, delta = -depth n is the displacement of the surface under the tip and the
/// force is Eq. 29's at the triangle's three corners, blended by the foot's weights, so that it is
/// continuous while the tip slides from triangle to triangle. A press cannot pull: a component
/// of the reaction into the tissue is removed. A tip of radius 0 presses when it is below the
/// surface.
///
/// Grasp (the patch's kind is kGrasp): delta = X_WT p_grasp_T - p_grasp_original_W with the grasp's
/// own node. A jaw opened beyond 0.5 lets go in the same tick, whatever the patch says; the tip
/// may then press.
///
/// Haptic thread; wait-free, no allocation, never throws. The cost is bounded by the patch's 96
/// triangles, not by the mesh.
class TipContact {
 public:
  static constexpr double kJawLetsGo = 0.5;

  /// Takes a new patch, which must stay unchanged until the next SetPatch (TripleBuffer::Front).
  void SetPatch(const ToolPatch& patch) noexcept;

  /// No patch: no contact.
  void ClearPatch() noexcept { patch_ = nullptr; }

  /// X_WT: the tool's pose; jaw 0 closed .. 1 open; tip_radius in m.
  ContactResult Evaluate(const Isometry3d& X_WT, double jaw, double tip_radius) noexcept;

 private:
  ContactResult EvaluatePress(const Vector3d& p_tip_W, double tip_radius);
  ContactResult EvaluateGrasp(const Isometry3d& X_WT) const;

  const ToolPatch* patch_ = nullptr;
  PatchSurface surface_;
};

}  // namespace hpdm
