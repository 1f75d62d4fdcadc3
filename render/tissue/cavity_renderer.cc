#include "render/tissue/cavity_renderer.h"

#include <epoxy/gl.h>

#include <vector>

#include "render/camera/frame_uniforms.h"
#include "render/shader_sources.h"
#include "render/tissue/tissue_detail.h"

namespace hpdm {
namespace {

constexpr int kTextureUnit = 0;

std::vector<const char*> FragmentParts(bool picture) {
  if (picture) return {glsl::kFrame, glsl::kLight, glsl::kCavityWall, glsl::kCavityPicture};
  return {glsl::kFrame,        glsl::kLight,      glsl::kTissue,
          glsl::kTissueDetail, glsl::kCavityWall, glsl::kCavityBare};
}

}  // namespace

CavityRenderer::CavityRenderer(const Image* background)
    : program_("cavity", {glsl::kFrame, glsl::kCavityVertex}, FragmentParts(background != nullptr)),
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
  // Large enough to contain the scope.
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
