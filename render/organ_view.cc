#include "render/organ_view.h"

#include <epoxy/gl.h>

#include "engine/check.h"
#include "render/frame_uniforms.h"
#include "render/lighting.h"

namespace hpdm {
namespace {

constexpr const char* kVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 rest;
layout(location = 3) in vec2 texture_coordinate;
out vec3 p_W;
out vec3 normal_W;
out vec3 pattern;
out vec2 uv;
void main() {
  p_W = position;
  normal_W = normal;
  pattern = rest;
  uv = texture_coordinate;
  gl_Position = clip_from_world * vec4(position, 1.0);
}
)glsl";

constexpr const char* kFragment = R"glsl(
in vec3 p_W;
in vec3 normal_W;
in vec3 pattern;
in vec2 uv;
uniform vec3 base_colour;
uniform sampler2D base_texture;
out vec4 colour;
void main() {
  vec3 base = base_colour * texture(base_texture, uv).rgb;
  colour = Encode(ShadeTissue(p_W, normal_W, pattern, base, 1.0));
}
)glsl";

constexpr int kBaseTextureUnit = 0;

const Image& White() {
  static const Image white{1, 1, {255, 255, 255}};
  return white;
}

}  // namespace

OrganPainter::OrganPainter(const std::vector<OrganView>& organs)
    : program_("organ", {glsl::kFrame, kVertex},
               {glsl::kFrame, glsl::kLight, glsl::kPattern, glsl::kTissue, kFragment}),
      base_colour_(program_.Uniform("base_colour")) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
  program_.BindTexture("base_texture", kBaseTextureUnit);
  organs_.reserve(organs.size());
  for (const OrganView& organ : organs) {
    const bool textured = organ.texture != nullptr;
    HPDM_CHECK(!textured || organ.rest->texture_coordinates.rows() > 0);
    organs_.push_back({MeshView(*organ.rest), Texture(textured ? *organ.texture : White()),
                       textured ? Eigen::Vector3f(1, 1, 1) : Linear(organ.colour)});
  }
}

void OrganPainter::Draw(const SceneSnapshot& snapshot) {
  HPDM_CHECK(snapshot.organs.size() >= organs_.size());
  program_.Use();
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    organs_[o].mesh.SetVertices(snapshot.organs[o].vertices);
    organs_[o].texture.Bind(kBaseTextureUnit);
    glUniform3fv(base_colour_, 1, organs_[o].colour.data());
    organs_[o].mesh.Draw();
  }
}

}  // namespace hpdm
