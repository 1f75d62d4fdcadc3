#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/snapshots.h"
#include "render/heat_painter.h"
#include "render/laparoscope.h"
#include "render/mark_painter.h"
#include "render/organ_view.h"

namespace hpdm {

/// N: the force with the last colour of kOverlayForce; gentle presses and grasps stay below.
inline constexpr double kForceScale = 2;

/// The end of kOverlayError's scale, m, for a reference's displacements (V x 3, m): a quarter of
/// the largest one, rounded up to 1, 2 or 5 times a power of ten.
double ErrorScale(const Points& reference);

/// What may be drawn over the picture (view_settings.h), but for the text. Render thread only.
class OverlayView {
 public:
  /// Compiles the programs. Throws MachineError when the driver refuses a shader.
  explicit OverlayView(const std::vector<OrganView>& organs);

  /// Draws the overlays (Overlay, or-ed) over a picture that has just been drawn of `snapshot`
  /// through `scope`, whose frame's uniforms are bound. Without any, nothing happens.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope, std::uint32_t overlays,
            OrganPainter* organs);

 private:
  void DrawForces(const SceneSnapshot& snapshot, const OrganPainter& organs);
  void DrawErrors(const SceneSnapshot& snapshot, OrganPainter* organs);

  std::vector<OrganView> organs_;
  HeatPainter heat_;
  MarkPainter marks_painter_;
  Marks marks_;               // scratch
  std::vector<float> error_;  // scratch
};

}  // namespace hpdm
