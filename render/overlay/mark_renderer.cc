#include "render/overlay/mark_renderer.h"

#include <epoxy/gl.h>

#include <cstddef>

#include "render/camera/frame_uniforms.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

static_assert(sizeof(Mark) == 12 * sizeof(float), "three vec4 of the vertex shader");

void SetInput(GLuint index, std::size_t first) {
  glVertexAttribPointer(index, 4, GL_FLOAT, GL_FALSE, sizeof(Mark),
                        reinterpret_cast<const void*>(first));
  glVertexAttribDivisor(index, 1);
  glEnableVertexAttribArray(index);
}

}  // namespace

MarkRenderer::MarkRenderer()
    : program_("marks", {glsl::kFrame, glsl::kMarkVertex}, {glsl::kFrame, glsl::kMarkFragment}),
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
