#include "render/scene_view.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "engine/check.h"
#include "render/capsule_mesh.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr GLuint kFrameBinding = 0;
constexpr double kCrease = std::numbers::pi / 5;  // rad: sharper edges of an instrument stay sharp
constexpr double kShaftLength = 0.40;             // m: longer than any insertion
constexpr double kSoftEdge = 0.012;               // of the circle's radius

/// The uniform block Frame in std140 layout; the shader source says what the members are.
struct FrameUniforms {
  Eigen::Matrix4f clip_from_world;
  Eigen::Vector4f lens_W;
  Eigen::Vector4f light_W;
  Eigen::Vector4f axis_W;
  Eigen::Vector4f right_W;
  Eigen::Vector4f up_W;
  Eigen::Vector4f circle_px;
  Eigen::Vector4f cavity_W;
  Eigen::Vector4f tool_tip_W[kMaxInstruments];
  Eigen::Vector4f tool_axis_W[kMaxInstruments];
};
static_assert(sizeof(FrameUniforms) == 64 + 16 * (7 + 2 * kMaxInstruments));
static_assert(kMaxInstruments == 2, "kMaxTools in the shaders");

Eigen::Vector4f WithW(const Vector3d& v, double w) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()),
          static_cast<float>(w)};
}

/// From the screen's sRGB curve to light.
Eigen::Vector3f Linear(const Colour& srgb) {
  return srgb.unaryExpr(
      [](float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); });
}

MeshView InstrumentMeshView(const InstrumentView& view) {
  if (view.mesh != nullptr) return MeshView(CutCreases(*view.mesh, kCrease));
  return MeshView(
      CutCreases(CapsuleMesh(view.tip_radius, view.shaft_radius, kShaftLength), kCrease));
}

}  // namespace

SceneView::MeshProgram::MeshProgram(const char* name,
                                    const std::vector<const char*>& fragment_parts)
    : program(name, {glsl::kFrame, glsl::kMeshVertex}, fragment_parts),
      world_from_mesh(program.Uniform("world_from_mesh")),
      base_colour(program.Uniform("base_colour")) {
  program.BindBlock("Frame", kFrameBinding);
}

void SceneView::MeshProgram::SetMesh(const Eigen::Matrix4f& pose,
                                     const Eigen::Vector3f& colour) const {
  glUniformMatrix4fv(world_from_mesh, 1, GL_FALSE, pose.data());
  glUniform3fv(base_colour, 1, colour.data());
}

SceneView::SceneView(const std::vector<OrganView>& organs,
                     const std::vector<InstrumentView>& instruments)
    : tissue_("tissue",
              {glsl::kFrame, glsl::kLight, glsl::kPattern, glsl::kTissue, glsl::kOrganMain}),
      metal_("metal", {glsl::kFrame, glsl::kLight, glsl::kMetalMain}),
      cavity_("cavity", {glsl::kFrame, glsl::kCavityVertex},
              {glsl::kFrame, glsl::kLight, glsl::kPattern, glsl::kTissue, glsl::kCavityMain}),
      surround_("surround", {glsl::kFrame, glsl::kSurroundVertex}, {glsl::kSurroundMain}) {
  HPDM_CHECK(instruments.size() <= kMaxInstruments);
  cavity_.BindBlock("Frame", kFrameBinding);
  surround_.BindBlock("Frame", kFrameBinding);
  organs_.reserve(organs.size());
  for (const OrganView& organ : organs) {
    organs_.push_back({MeshView(*organ.rest), Linear(organ.colour)});
  }
  instruments_.reserve(instruments.size());
  for (const InstrumentView& view : instruments) {
    instruments_.push_back({InstrumentMeshView(view), Linear(view.colour),
                            static_cast<float>(view.tip_radius),
                            static_cast<float>(view.shaft_radius)});
  }
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer_.name());
  glBufferData(GL_UNIFORM_BUFFER, sizeof(FrameUniforms), nullptr, GL_DYNAMIC_DRAW);
}

void SceneView::UploadFrame(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  FrameUniforms frame;
  const Vector3d axis_W = scope.ViewingAxis_W();
  const double distance = scope.target_distance();
  const double focal = scope.focal_length_px();
  frame.clip_from_world = scope.ClipFromWorld().cast<float>();
  frame.lens_W = WithW(scope.X_WC().translation(), 0);
  frame.light_W = WithW(scope.p_light_W(), distance * distance);
  frame.axis_W = WithW(axis_W, 0);
  frame.right_W = WithW(scope.X_WC().linear().col(0) * (scope.width() / (2 * focal)), 0);
  frame.up_W = WithW(scope.X_WC().linear().col(1) * (scope.height() / (2 * focal)), 0);
  frame.circle_px =
      Eigen::Vector4d(0.5 * scope.width(), 0.5 * scope.height(), scope.circle_radius_px(),
                      std::max(1.5, kSoftEdge * scope.circle_radius_px()))
          .cast<float>();
  // Centred on the target and wide enough to hold the scope.
  frame.cavity_W = WithW(scope.X_WC().translation() + distance * axis_W, 1.15 * distance);
  for (int t = 0; t < kMaxInstruments; ++t) {
    const bool drawn = t < static_cast<int>(instruments_.size()) && t < snapshot.tool_count;
    const Isometry3d& X_WT = snapshot.tools[t].X_WT;
    frame.tool_tip_W[t] = WithW(X_WT.translation(), drawn ? instruments_[t].tip_radius : 0);
    frame.tool_axis_W[t] = WithW(X_WT.linear().col(2), drawn ? instruments_[t].shaft_radius : 0);
  }
  glBindBuffer(GL_UNIFORM_BUFFER, frame_buffer_.name());
  glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof frame, &frame);
  glBindBufferBase(GL_UNIFORM_BUFFER, kFrameBinding, frame_buffer_.name());
}

void SceneView::Draw(const SceneSnapshot& snapshot, const Laparoscope& scope) {
  HPDM_CHECK(snapshot.organs.size() >= organs_.size());
  UploadFrame(snapshot, scope);

  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);

  // Nearest first, farthest last: what is hidden, or outside the circle, is not shaded.
  surround_.Use();
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 2 * 97);

  metal_.program.Use();
  // Instruments have no pose before the first tick.
  const std::size_t tools =
      std::min(instruments_.size(), static_cast<std::size_t>(snapshot.tool_count));
  for (std::size_t t = 0; t < tools; ++t) {
    metal_.SetMesh(snapshot.tools[t].X_WT.matrix().cast<float>(), instruments_[t].colour);
    instruments_[t].mesh.Draw();
  }

  tissue_.program.Use();
  for (std::size_t o = 0; o < organs_.size(); ++o) {
    organs_[o].mesh.SetVertices(snapshot.organs[o].vertices);
    tissue_.SetMesh(Eigen::Matrix4f::Identity(), organs_[o].colour);
    organs_[o].mesh.Draw();
  }

  cavity_.Use();
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace hpdm
