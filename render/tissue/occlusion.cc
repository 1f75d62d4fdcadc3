#include "render/tissue/occlusion.h"

#include <epoxy/gl.h>

#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr int kDepthUnit = 0;

constexpr float kStrength = 1.4f;

void SetStorage(const GlObject& texture, GLint format, GLenum of, GLenum type, int width,
                int height, GLint filter) {
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, format, width, height, 0, of, type, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

}  // namespace

Occlusion::Occlusion()
    : program_("occlusion", {glsl::kOcclusionVertex}, {glsl::kOcclusionFragment}),
      sampling_(program_.Uniform("sampling")),
      inverse_depth_(program_.Uniform("inverse_depth")) {
  program_.BindTexture("depth", kDepthUnit);
}

void Occlusion::Resize(int width, int height) {
  width_ = width;
  height_ = height;
  SetStorage(depth_, GL_DEPTH_COMPONENT24, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, width, height,
             GL_NEAREST);
  SetStorage(open_, GL_R8, GL_RED, GL_UNSIGNED_BYTE, width, height, GL_LINEAR);
  glBindFramebuffer(GL_FRAMEBUFFER, depth_target_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, depth_.name(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  glBindFramebuffer(GL_FRAMEBUFFER, open_target_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, open_.name(), 0);
}

void Occlusion::Update(const Laparoscope& scope, const std::function<void()>& draw_depth) {
  GLint framebuffer = 0, viewport[4];
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &framebuffer);
  glGetIntegerv(GL_VIEWPORT, viewport);

  const int width = (scope.width() + 1) / 2, height = (scope.height() + 1) / 2;
  if (width != width_ || height != height_) Resize(width, height);
  glViewport(0, 0, width_, height_);
  glBindFramebuffer(GL_FRAMEBUFFER, depth_target_.name());
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  draw_depth();

  glBindFramebuffer(GL_FRAMEBUFFER, open_target_.name());
  glDisable(GL_DEPTH_TEST);
  program_.Use();
  // The depth buffer is affine in 1 / z between the near and the far plane.
  constexpr double kNear = Laparoscope::kNear, kFar = Laparoscope::kFar;
  glUniform2f(inverse_depth_, static_cast<float>(1 / kNear),
              static_cast<float>(1 / kFar - 1 / kNear));
  glUniform3f(sampling_, static_cast<float>(0.5 * scope.focal_length_px() * kRadius),
              static_cast<float>(kRadius), kStrength);
  glActiveTexture(GL_TEXTURE0 + kDepthUnit);
  glBindTexture(GL_TEXTURE_2D, depth_.name());
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);

  glBindFramebuffer(GL_FRAMEBUFFER, static_cast<GLuint>(framebuffer));
  glViewport(viewport[0], viewport[1], viewport[2], viewport[3]);
}

void Occlusion::Bind(int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_2D, open_.name());
}

}  // namespace hpdm
