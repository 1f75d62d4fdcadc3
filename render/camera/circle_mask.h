#pragma once

#include "render/gl/gl_object.h"
#include "render/gl/shaders.h"

namespace hpdm {

/// The dark outside of the circular picture, with a notch at its top that tells which way the
/// camera is held. Drawn first, it keeps everything behind it from being
/// shaded. Render thread only.
class CircleMask {
 public:
  /// Throws MachineError when the driver refuses the shader.
  CircleMask();
  void Draw() const;

 private:
  ShaderProgram program_;
  GlObject no_inputs_{GlKind::kVertexArray};
};

}  // namespace hpdm
