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

/// Radius of a force's colour spot in kernel radii: visible around the tip, which covers the
/// kernel.
inline constexpr double kForceSpotRadii = 8;

/// Returns the end of a scale for `value`: the smallest of 1, 2 and 5 times a power of ten that is
/// not below it; 1e-3 for 0.
double RoundedUp(double value);

/// Draws the overlays of view_settings.h, except the text. Render thread only.
class OverlayRenderer {
 public:
  /// Compiles the programs. Throws MachineError if the driver refuses a shader.
  explicit OverlayRenderer(const std::vector<OrganVisual>& organs);

  /// Draws the overlays (Overlay, or-ed) over a picture that has just been drawn of `snapshot`
  /// through `scope`. The frame's uniforms must be bound.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope, std::uint32_t overlays,
            OrganRenderer* organs);

  /// Draws the overlays' colour scales beside a resolved picture: the force's outermost, then the
  /// error's. The frame's uniforms must be bound.
  void DrawScales(std::uint32_t overlays);

 private:
  void AddContact(const SolvedContact& contact, const SceneSnapshot& snapshot);
  void DrawForces(const SceneSnapshot& snapshot, const OrganRenderer& organs);
  void DrawErrors(const SceneSnapshot& snapshot, OrganRenderer* organs);

  std::vector<OrganVisual> organs_;
  std::vector<Eigen::VectorXf> presence_;  // for each organ, ControlPointPresence
  HeatRenderer heat_;
  MarkRenderer mark_renderer_;
  Marks marks_;               // scratch
  std::vector<float> error_;  // scratch
};

}  // namespace hpdm
