#pragma once

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

/// Draws the black outside of the circular picture, with a notch at its top that shows the
/// camera's roll. Drawn first, it saves the shading of everything behind it. Render thread only.
class CircleMask {
 public:
  /// Throws MachineError if the driver refuses the shader.
  CircleMask();
  void Draw() const;

 private:
  ShaderProgram program_;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
