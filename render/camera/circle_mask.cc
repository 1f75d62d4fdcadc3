#include "render/camera/circle_mask.h"

#include <epoxy/gl.h>

#include "render/camera/frame_uniforms.h"
#include "render/shader_sources.h"

namespace hpdm {
CircleMask::CircleMask()
    : program_("circle mask", {glsl::kFrame, glsl::kMaskVertex}, {glsl::kMaskFragment}) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
}

void CircleMask::Draw() const {
  program_.Use();
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 2 * 97);
  glDrawArrays(GL_TRIANGLES, 2 * 97, 3);
}

}  // namespace hpdm
