#include "render/camera/lens_pass.h"

#include <epoxy/gl.h>

#include "render/camera/laparoscope.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr int kPictureUnit = 0;
constexpr int kSectors = 48;
constexpr int kRings = 24;

}  // namespace

LensPass::LensPass(Edges edges)
    : program_("lens", {glsl::kLensVertex},
               {edges == Edges::kSmoothed ? glsl::kLensSmooth : glsl::kLensCopy}),
      circle_(program_.Uniform("circle")),
      distortion_(program_.Uniform("distortion")) {
  program_.BindTexture("picture", kPictureUnit);
}

void LensPass::Draw(const Laparoscope& scope, const GlObject& texture) const {
  const int rings = scope.distortion() == 0 ? 1 : kRings;
  glDisable(GL_DEPTH_TEST);
  glClear(GL_COLOR_BUFFER_BIT);
  program_.Use();
  glUniform3f(circle_, static_cast<float>(2 * scope.circle_radius_px() / scope.width()),
              static_cast<float>(2 * scope.circle_radius_px() / scope.height()),
              static_cast<float>(rings));
  glUniform1f(distortion_, static_cast<float>(scope.distortion()));
  glActiveTexture(GL_TEXTURE0 + kPictureUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glBindVertexArray(no_inputs_.name());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * (kSectors + 1), rings);
}

}  // namespace hpdm
