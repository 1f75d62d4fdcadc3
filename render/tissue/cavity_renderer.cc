#include "render/tissue/cavity_renderer.h"

#include <epoxy/gl.h>

#include <vector>

#include "render/camera/frame_uniforms.h"
#include "render/tissue/lighting.h"
#include "render/tissue/tissue_detail.h"

namespace hpdm {
namespace {

constexpr const char* kCavityVertex = R"glsl(
out vec3 ray_W;
void main() {
  vec2 clip = vec2(gl_VertexID == 1 ? 3.0 : -1.0, gl_VertexID == 2 ? 3.0 : -1.0);
  ray_W = axis_W.xyz + clip.x * right_W.xyz + clip.y * up_W.xyz;
  gl_Position = vec4(clip, 1.0, 1.0);
}
)glsl";

// Where the lens's ray meets the wall.
constexpr const char* kWall = R"glsl(
in vec3 ray_W;
uniform vec4 sphere_W;   // centre, radius
out vec4 colour;
vec3 WallPoint() {
  vec3 ray = normalize(ray_W);
  vec3 from_centre = lens_W.xyz - sphere_W.xyz;
  float b = dot(from_centre, ray);
  float c = dot(from_centre, from_centre) - sphere_W.w * sphere_W.w;
  return lens_W.xyz + (sqrt(max(b * b - c, 0.0)) - b) * ray;
}
)glsl";

// Without a picture: dark folds, from the relief of tissue at two coarse scales, laid on the sphere
// stereographically from behind the first lens.
constexpr const char* kBareWall = R"glsl(
uniform mat3 camera_from_world;   // the first frame's
void main() {
  vec3 p = WallPoint();
  vec3 inwards = (sphere_W.xyz - p) / sphere_W.w;
  vec3 d = camera_from_world * -inwards;
  vec2 m = 2.0 * sphere_W.w * d.xy / max(1.0 - d.z, 0.05);
  Detail folds = DetailAt(0.30 * m);
  Detail grain = DetailAt(1.7 * m);
  vec3 n = inwards;
  vec3 rough = Raised(p, n, m, folds.slope + 0.5 * grain.slope);
  vec3 base = mix(vec3(0.17, 0.035, 0.028), vec3(0.30, 0.11, 0.07), folds.height);
  vec3 to_lens = normalize(lens_W.xyz - p);
  colour = Encode(0.6 * ShadeTissue(p, to_lens, n, rough, 0.1 + folds.spread + grain.spread, base));
}
)glsl";

constexpr const char* kPictureWall = R"glsl(
uniform sampler2D background;
uniform mat3 slide_from_world;   // turns into the projector's camera frame, x and y in slides
uniform vec3 projector_W;
void main() {
  vec3 p = WallPoint();
  vec3 d = slide_from_world * normalize(p - projector_W);
  // Beyond 70 degrees off its axis, which the first picture never shows, the slide bends back.
  vec2 slide = 0.5 + 0.5 * d.xy / max(-d.z, 0.34);
  vec3 to_light;
  float irradiance = Irradiance(p, to_light);
  colour = Encode(2.0 * irradiance * texture(background, slide).rgb);
}
)glsl";

constexpr int kTextureUnit = 0;

std::vector<const char*> FragmentParts(bool picture) {
  if (picture) return {glsl::kFrame, glsl::kLight, kWall, kPictureWall};
  return {glsl::kFrame, glsl::kLight, glsl::kTissue, glsl::kTissueDetail, kWall, kBareWall};
}

}  // namespace

CavityRenderer::CavityRenderer(const Image* background)
    : program_("cavity", {glsl::kFrame, kCavityVertex}, FragmentParts(background != nullptr)),
      has_picture_(background != nullptr) {
  program_.BindBlock("Frame", FrameBlock::kBinding);
  if (background == nullptr) {
    program_.BindTexture("tissue_detail", kTextureUnit);
    texture_.emplace(TissueDetail());
    return;
  }
  program_.BindTexture("background", kTextureUnit);
  texture_.emplace(*background, Texture::Border::kMirror);
  const Eigen::Vector2f size(background->width, background->height);
  slide_size_ = size / size.minCoeff();
}

void CavityRenderer::Place(const Laparoscope& scope) {
  const Vector3d p_target_W =
      scope.X_WC().translation() + scope.target_distance() * scope.ViewingAxis_W();
  // Wide enough to hold the scope.
  const Eigen::Vector4f sphere_W = WithW(p_target_W, 1.15 * scope.target_distance());
  glUniform4fv(program_.Uniform("sphere_W"), 1, sphere_W.data());
  placed_ = true;
  Eigen::Matrix3f camera_from_world = scope.X_WC().linear().transpose().cast<float>();
  if (!has_picture_) {
    glUniformMatrix3fv(program_.Uniform("camera_from_world"), 1, GL_FALSE,
                       camera_from_world.data());
    return;
  }
  const Eigen::Vector3f projector_W = scope.X_WC().translation().cast<float>();
  glUniform3fv(program_.Uniform("projector_W"), 1, projector_W.data());
  const auto circle_tangent =
      static_cast<float>(scope.circle_radius_px() / scope.focal_length_px());
  Eigen::Matrix3f slide_from_world = camera_from_world;
  for (int i = 0; i < 2; ++i) slide_from_world.row(i) /= circle_tangent * slide_size_[i];
  glUniformMatrix3fv(program_.Uniform("slide_from_world"), 1, GL_FALSE, slide_from_world.data());
}

void CavityRenderer::Draw(const Laparoscope& scope) {
  program_.Use();
  if (!placed_) Place(scope);
  texture_->Bind(kTextureUnit);
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace hpdm
