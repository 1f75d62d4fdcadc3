#include "render/camera/lens_pass.h"

#include <epoxy/gl.h>

#include "render/camera/laparoscope.h"

namespace hpdm {
namespace {

constexpr int kPictureUnit = 0;
constexpr int kSectors = 48;
constexpr int kRings = 24;

constexpr const char* kLensVertex = R"glsl(
uniform vec3 circle;        // radius in the picture's half width and half height; rings
uniform float distortion;
out vec2 place;
// A strip a ring: even vertices on its inner, odd ones on its outer circle. In radii of the circle.
void main() {
  float ring = float(gl_InstanceID + gl_VertexID % 2);
  float r = 1.02 * ring / circle.z;   // to the end of the soft edge
  float angle = 6.2831853 * float(gl_VertexID / 2) / 48.0;
  vec2 direction = circle.xy * vec2(cos(angle), sin(angle));
  place = 0.5 + 0.5 * r * direction;
  gl_Position = vec4(r * (1.0 + distortion * r * r) / (1.0 + distortion) * direction, 0.0, 1.0);
}
)glsl";

constexpr const char* kAsDrawn = R"glsl(
in vec2 place;
uniform sampler2D picture;
out vec4 colour;
void main() { colour = textureLod(picture, place, 0.0); }
)glsl";

// The brightness of the four diagonal neighbours tells how strong the edge through a pixel is and
// which way it runs; the pixel becomes the mean of places along it, near ones if the far ones
// belong to something else.
constexpr const char* kSmoothed = R"glsl(
in vec2 place;
uniform sampler2D picture;
out vec4 colour;
float Brightness(vec3 c) { return dot(c, vec3(0.4, 0.5, 0.1)); }
float BrightnessAt(ivec2 pixel) { return Brightness(texelFetch(picture, pixel, 0).rgb); }
vec3 At(vec2 where) { return textureLod(picture, where, 0.0).rgb; }
void main() {
  vec2 size = vec2(textureSize(picture, 0));
  vec3 here = At(place);
  float b = Brightness(here);
  ivec2 pixel = clamp(ivec2(place * size), ivec2(1), ivec2(size) - 2);
  float b00 = BrightnessAt(pixel + ivec2(-1, -1));
  float b10 = BrightnessAt(pixel + ivec2(1, -1));
  float b01 = BrightnessAt(pixel + ivec2(-1, 1));
  float b11 = BrightnessAt(pixel + ivec2(1, 1));
  float darkest = min(b, min(min(b00, b10), min(b01, b11)));
  float brightest = max(b, max(max(b00, b10), max(b01, b11)));
  colour = vec4(here, 1.0);
  if (brightest - darkest < max(0.035, 0.15 * brightest)) return;
  vec2 along = vec2(b01 + b11 - b00 - b10, b00 + b01 - b10 - b11);
  float least = min(abs(along.x), abs(along.y)) + 0.03 * (b00 + b10 + b01 + b11) + 0.008;
  vec2 stride = clamp(along / least, -6.0, 6.0) / size;
  vec3 near = 0.5 * (At(place - stride / 6.0) + At(place + stride / 6.0));
  vec3 far = 0.5 * near + 0.25 * (At(place - 0.5 * stride) + At(place + 0.5 * stride));
  float b_far = Brightness(far);
  colour.rgb = b_far < darkest || b_far > brightest ? near : far;
}
)glsl";

}  // namespace

LensPass::LensPass(Edges edges)
    : program_("lens", {kLensVertex}, {edges == Edges::kSmoothed ? kSmoothed : kAsDrawn}),
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
