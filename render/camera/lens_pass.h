#pragma once

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

class Laparoscope;

/// What the finished pinhole picture goes through inside the circle; outside it is black.
///
/// Edges: where the picture was drawn with one sample a pixel, pixels on an edge are blended along
/// it (FXAA, Lottes 2009).
///
/// The lens's distortion: the picture moves along the circle's radius, on rings of triangles whose
/// corners are where Laparoscope::Distorted says, so that a pixel costs one look-up and nothing is
/// inverted. Between the rings it is linear, which is off by less than 6e-4 of the circle's radius.
///
/// Render thread only.
class LensPass {
 public:
  enum class Edges { kAsDrawn, kSmoothed };

  /// Throws MachineError when the driver refuses the shader.
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
