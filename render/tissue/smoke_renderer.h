#pragma once

#include "engine/snapshots.h"
#include "render/camera/laparoscope.h"
#include "render/overlay/mark_renderer.h"

namespace hpdm {

/// Returns the marks of a scene's smoke: each puff rises along the world's z axis, spreads and fades
/// within SmokePuff::kLife. The same snapshot gives the same marks.
void AddSmokeMarks(const SceneSnapshot& snapshot, const Laparoscope& scope, Marks* marks);

/// Draws the smoke of energised hooks. Render thread only.
class SmokeRenderer {
 public:
  /// Throws MachineError if the driver refuses a shader.
  SmokeRenderer() = default;

  /// Draws into a picture that has just been drawn of `snapshot`.
  void Draw(const SceneSnapshot& snapshot, const Laparoscope& scope);

 private:
  MarkRenderer mark_renderer_;
  Marks marks_;  // scratch
};

}  // namespace hpdm
