#pragma once

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

class Laparoscope;

/// Post-processes the finished pinhole picture inside the circle and draws black outside it:
///
///   1. Edges: if the picture has one sample a pixel, pixels on an edge are blended along it (FXAA,
///      Lottes 2009).
///   2. Distortion: moves the picture along the circle's radius, on rings of triangles whose
///      corners follow Laparoscope::Distorted. A pixel costs one look-up, without an inversion.
///      Linear interpolation between the rings is off by less than 6e-4 of the circle's radius.
///
/// Render thread only.
class LensPass {
 public:
  enum class Edges { kAsDrawn, kSmoothed };

  /// Throws MachineError if the driver refuses the shader.
  explicit LensPass(Edges edges);

  /// Draws the picture in `texture` (a 2D texture of the scope's picture size) into the bound
  /// framebuffer. Leaves depth testing off.
  void Draw(const Laparoscope& scope, const GlObject& texture) const;

 private:
  ShaderProgram program_;
  int circle_;
  int distortion_;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
