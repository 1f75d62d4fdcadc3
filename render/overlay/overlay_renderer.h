#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/overlay/heat_renderer.h"
#include "render/overlay/mark_renderer.h"
#include "render/overlay/view_settings.h"
#include "render/tissue/organ_renderer.h"

namespace hpdm {

/// Radii of a contact's kernel that its colour reaches: seen around the tip that covers the kernel.
inline constexpr double kForceSpotRadii = 8;

/// The least of 1, 2 and 5 times a power of ten that is not below `value` > 0: the end of a scale.
/// 1e-3 for 0.
double RoundedUp(double value);

/// What may be drawn over the picture (view_settings.h), but for the text. Render thread only.
class OverlayRenderer {
 public:
  /// Compiles the programs. Throws MachineError when the driver refuses a shader.
  explicit OverlayRenderer(const std::vector<OrganVisual>& organs);

  /// Draws the overlays (Overlay, or-ed) over a picture that has just been drawn of `snapshot`
  /// through `scope`, whose frame's uniforms are bound. Without any, nothing happens.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope, std::uint32_t overlays,
            OrganRenderer* organs);

  /// Draws the colours of the overlays that have a scale beside a resolved picture: force, then
  /// error inwards of it. The frame's uniforms are still bound.
  void DrawScales(std::uint32_t overlays);

 private:
  void DrawForces(const SceneSnapshot& snapshot, const OrganRenderer& organs);
  void DrawErrors(const SceneSnapshot& snapshot, OrganRenderer* organs);

  std::vector<OrganVisual> organs_;
  std::vector<Eigen::VectorXf> presence_;  // by organ, of its control points
  HeatRenderer heat_;
  MarkRenderer mark_renderer_;
  Marks marks_;               // scratch
  std::vector<float> error_;  // scratch
};

}  // namespace hpdm
