#include "render/lens_warp.h"

#include <epoxy/gl.h>

namespace hpdm {
namespace {

constexpr int kPictureUnit = 0;
constexpr int kSectors = 96;

constexpr const char* kVertex = R"glsl(
uniform vec3 circle;        // radius in the picture's half width and half height; rings
uniform float distortion;
out vec2 place;
// A strip a ring: even vertices on its inner, odd ones on its outer circle. In radii of the circle.
void main() {
  float ring = float(gl_InstanceID + gl_VertexID % 2);
  float r = 1.02 * ring / circle.z;   // to the end of the soft edge
  float angle = 6.2831853 * float(gl_VertexID / 2) / 96.0;
  vec2 direction = circle.xy * vec2(cos(angle), sin(angle));
  place = 0.5 + 0.5 * r * direction;
  gl_Position = vec4(r * (1.0 + distortion * r * r) / (1.0 + distortion) * direction, 0.0, 1.0);
}
)glsl";

constexpr const char* kFragment = R"glsl(
in vec2 place;
uniform sampler2D picture;
out vec4 colour;
void main() { colour = texture(picture, place); }
)glsl";

}  // namespace

LensWarp::LensWarp()
    : program_("lens", {kVertex}, {kFragment}),
      circle_(program_.Uniform("circle")),
      distortion_(program_.Uniform("distortion")) {
  program_.BindTexture("picture", kPictureUnit);
}

void LensWarp::Draw(const Laparoscope& scope, const GlObject& texture) const {
  glDisable(GL_DEPTH_TEST);
  glClear(GL_COLOR_BUFFER_BIT);
  program_.Use();
  glUniform3f(circle_, static_cast<float>(2 * scope.circle_radius_px() / scope.width()),
              static_cast<float>(2 * scope.circle_radius_px() / scope.height()), kRings);
  glUniform1f(distortion_, static_cast<float>(scope.distortion()));
  glActiveTexture(GL_TEXTURE0 + kPictureUnit);
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glBindVertexArray(no_inputs_.name());
  glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 2 * (kSectors + 1), kRings);
}

}  // namespace hpdm
