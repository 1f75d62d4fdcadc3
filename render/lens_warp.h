#pragma once

#include "render/gl_object.h"
#include "render/laparoscope.h"
#include "render/shaders.h"

namespace hpdm {

/// Moves a pinhole's picture along the circle's radius to where a distorting lens puts it: rings of
/// triangles whose corners are where Laparoscope::Distorted says, so that a pixel costs one
/// look-up. Between the rings it is linear, which is off by less than 0.05 px in a circle of 1,000.
/// Render thread only.
class LensWarp {
 public:
  /// Throws MachineError when the driver refuses the shader.
  LensWarp();

  /// Draws the picture in `texture` (a 2D texture of the scope's picture size) into the bound
  /// framebuffer; black outside the circle. Leaves depth testing off.
  void Draw(const Laparoscope& scope, const GlObject& texture) const;

 private:
  static constexpr int kRings = 64;

  ShaderProgram program_;
  int circle_;
  int distortion_;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
