#include "render/overlay/mark_renderer.h"

#include <epoxy/gl.h>

#include <cstddef>

#include "render/camera/frame_uniforms.h"

namespace hpdm {
namespace {

constexpr const char* kMarkVertex = R"glsl(
layout(location = 0) in vec4 a;       // position in the world, radius in pixels
layout(location = 1) in vec4 b;
layout(location = 2) in vec4 paint;   // colour as on a screen, opacity
noperspective out vec2 at;            // px
flat out vec2 from;
flat out vec2 to;
flat out vec2 radii;
flat out vec4 ink;
uniform float fade_from;      // m

const float kNear = 0.002;            // m, Laparoscope::kNear
const float kLift = 0.001;            // m towards the lens, so that a surface does not hide its own

vec4 Clip(vec3 p) {
  return clip_from_world * vec4(p + kLift * normalize(lens_W.xyz - p), 1.0);
}

// A rectangle around the stroke.
void main() {
  vec4 clip_a = Clip(a.xyz), clip_b = Clip(b.xyz);
  ink = paint;
  radii = vec2(a.w, b.w);
  if (max(clip_a.w, clip_b.w) <= kNear) {   // behind the lens
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  // The part in front of the lens.
  if (clip_a.w < kNear) clip_a = mix(clip_b, clip_a, (clip_b.w - kNear) / (clip_b.w - clip_a.w));
  if (clip_b.w < kNear) clip_b = mix(clip_a, clip_b, (clip_a.w - kNear) / (clip_a.w - clip_b.w));
  float beyond = 0.5 * (clip_a.w + clip_b.w) / fade_from - 1.0;
  ink.a *= clamp(1.0 - 2.0 * beyond, 0.2, 1.0);
  from = (clip_a.xy / clip_a.w + 1.0) * circle_px.xy;
  to = (clip_b.xy / clip_b.w + 1.0) * circle_px.xy;
  vec2 along = to - from;
  along = dot(along, along) > 1e-8 ? normalize(along) : vec2(1.0, 0.0);
  float r = max(a.w, b.w) + 1.0;
  bool at_b = (gl_VertexID & 1) == 1;
  vec2 across = ((gl_VertexID & 2) == 2 ? r : -r) * vec2(-along.y, along.x);
  at = (at_b ? to + r * along : from - r * along) + across;
  float depth = at_b ? clip_b.z / clip_b.w : clip_a.z / clip_a.w;
  gl_Position = vec4(at / circle_px.xy - 1.0, depth, 1.0);
}
)glsl";

constexpr const char* kMarkFragment = R"glsl(
noperspective in vec2 at;
flat in vec2 from;
flat in vec2 to;
flat in vec2 radii;
flat in vec4 ink;
uniform float opacity;
out vec4 colour;
void main() {
  vec2 along = to - from;
  float share = clamp(dot(at - from, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
  float outside = distance(at, mix(from, to, share)) - mix(radii.x, radii.y, share);
  float beyond_circle = distance(at, circle_px.xy) - circle_px.z;
  float covered = clamp(0.5 - outside, 0.0, 1.0) * clamp(0.5 - beyond_circle, 0.0, 1.0);
  colour = vec4(ink.rgb, opacity * ink.a * covered);
}
)glsl";

static_assert(sizeof(Mark) == 12 * sizeof(float), "three vec4 of the vertex shader");

void SetInput(GLuint index, std::size_t first) {
  glVertexAttribPointer(index, 4, GL_FLOAT, GL_FALSE, sizeof(Mark),
                        reinterpret_cast<const void*>(first));
  glVertexAttribDivisor(index, 1);
  glEnableVertexAttribArray(index);
}

}  // namespace

MarkRenderer::MarkRenderer()
    : program_("marks", {glsl::kFrame, kMarkVertex}, {glsl::kFrame, kMarkFragment}),
      opacity_(program_.Uniform("opacity")),
      fade_from_(program_.Uniform("fade_from")) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
  glBindVertexArray(layout_.name());
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  SetInput(0, offsetof(Mark, a_W));
  SetInput(1, offsetof(Mark, b_W));
  SetInput(2, offsetof(Mark, colour));
  glBindVertexArray(0);
}

void MarkRenderer::Draw(const Marks& marks, float hidden, double fade_from) {
  if (marks.empty()) return;
  glBindBuffer(GL_ARRAY_BUFFER, buffer_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(marks.size() * sizeof(Mark)), marks.data(),
               GL_STREAM_DRAW);
  program_.Use();
  glUniform1f(fade_from_, static_cast<float>(fade_from));
  glBindVertexArray(layout_.name());
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  const auto draw = [&](GLenum where, float opacity) {
    if (opacity <= 0) return;
    glDepthFunc(where);
    glUniform1f(opacity_, opacity);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, static_cast<GLsizei>(marks.size()));
  };
  draw(GL_GREATER, hidden);
  draw(GL_LEQUAL, 1);
  glDepthFunc(GL_LEQUAL);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

}  // namespace hpdm
