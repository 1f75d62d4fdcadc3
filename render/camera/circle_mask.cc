#include "render/camera/circle_mask.h"

#include <epoxy/gl.h>

#include "render/camera/frame_uniforms.h"

namespace hpdm {
namespace {

constexpr const char* kMaskVertex = R"glsl(
// Vertex pairs around the circle: even ones just outside its soft edge, odd ones off the picture.
// Three more are the notch.
void main() {
  float angle = 6.2831853 * float(gl_VertexID / 2) / 96.0;
  // The chord of 1/96 of a turn runs inside its circle by less than 0.06 %.
  float radius = (circle_px.z + 0.5 * circle_px.w) * 1.001;
  radius = gl_VertexID % 2 == 0 ? radius : 2.0 * (circle_px.x + circle_px.y);
  vec2 from_centre = radius * vec2(cos(angle), sin(angle));
  if (gl_VertexID >= 194) {
    float side = float(gl_VertexID - 195);   // -1, 0, 1: left, apex, right
    from_centre = circle_px.z * vec2(0.028 * side, side == 0.0 ? 0.945 : 1.02);
  }
  gl_Position = vec4(from_centre / circle_px.xy, -1.0, 1.0);
}
)glsl";

constexpr const char* kMaskFragment = R"glsl(
out vec4 colour;
void main() { colour = vec4(0.0, 0.0, 0.0, 1.0); }
)glsl";

}  // namespace

CircleMask::CircleMask() : program_("circle mask", {glsl::kFrame, kMaskVertex}, {kMaskFragment}) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
}

void CircleMask::Draw() const {
  program_.Use();
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 2 * 97);
  glDrawArrays(GL_TRIANGLES, 2 * 97, 3);
}

}  // namespace hpdm
