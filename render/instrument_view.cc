#include "render/instrument_view.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "engine/check.h"
#include "render/capsule_mesh.h"
#include "render/lighting.h"

namespace hpdm {
namespace {

constexpr double kCrease = std::numbers::pi / 5;  // rad: sharper edges of an instrument stay sharp
constexpr double kShaftLength = 0.40;             // m: longer than any insertion

constexpr const char* kVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 world_from_mesh;   // rigid
out vec3 p_W;
out vec3 normal_W;
void main() {
  vec4 p = world_from_mesh * vec4(position, 1.0);
  p_W = p.xyz;
  normal_W = mat3(world_from_mesh) * normal;
  gl_Position = clip_from_world * p;
}
)glsl";

constexpr const char* kFragment = R"glsl(
in vec3 p_W;
in vec3 normal_W;
uniform vec3 base_colour;
out vec4 colour;
void main() {
  vec3 to_lens = normalize(lens_W.xyz - p_W);
  vec3 n = normalize(normal_W);
  n = faceforward(n, -to_lens, n);
  vec3 to_light;
  float irradiance = Irradiance(p_W, to_light);
  float n_l = max(dot(n, to_light), 0.0);
  // The surrounding it mirrors: red tissue, lit where the mirrored ray goes along the light.
  vec3 mirrored = reflect(-to_lens, n);
  float lit = 0.5 + 0.5 * dot(mirrored, axis_W.xyz);
  vec3 surrounding = mix(vec3(0.03, 0.015, 0.015), vec3(0.16, 0.11, 0.10), lit * lit);
  vec3 h = normalize(to_light + to_lens);
  float l_h = max(dot(to_light, h), 0.0);
  vec3 radiance = base_colour * (0.28 * irradiance * n_l * n_l + surrounding) +
                  base_colour * 2.5 * irradiance * n_l * Fresnel(0.6, l_h) *
                      Lobe(max(dot(n, h), 0.0), l_h, 0.36);
  colour = Encode(radiance);
}
)glsl";

MeshView InstrumentMesh(const InstrumentView& view) {
  if (view.mesh != nullptr) return MeshView(CutCreases(*view.mesh, kCrease));
  return MeshView(
      CutCreases(CapsuleMesh(view.tip_radius, view.shaft_radius, kShaftLength), kCrease));
}

}  // namespace

InstrumentPainter::InstrumentPainter(const std::vector<InstrumentView>& instruments)
    : program_("instrument", {glsl::kFrame, kVertex}, {glsl::kFrame, glsl::kLight, kFragment}),
      world_from_mesh_(program_.Uniform("world_from_mesh")),
      base_colour_(program_.Uniform("base_colour")) {
  HPDM_CHECK(instruments.size() <= kMaxInstruments);
  program_.BindBlock("Frame", FrameBlock::kBinding);
  instruments_.reserve(instruments.size());
  for (const InstrumentView& view : instruments) {
    instruments_.push_back(
        {InstrumentMesh(view), Linear(view.colour), view.tip_radius, view.shaft_radius});
  }
}

int InstrumentPainter::DrawnCount(const SceneSnapshot& snapshot) const {
  return std::min(static_cast<int>(instruments_.size()), snapshot.tool_count);
}

void InstrumentPainter::AddTo(const SceneSnapshot& snapshot, FrameUniforms* frame) const {
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const Isometry3d& X_WT = snapshot.tools[t].X_WT;
    frame->tool_tip_W[t] = WithW(X_WT.translation(), instruments_[t].tip_radius);
    frame->tool_axis_W[t] = WithW(X_WT.linear().col(2), instruments_[t].shaft_radius);
  }
}

void InstrumentPainter::Draw(const SceneSnapshot& snapshot) const {
  program_.Use();
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const Eigen::Matrix4f world_from_mesh = snapshot.tools[t].X_WT.matrix().cast<float>();
    glUniformMatrix4fv(world_from_mesh_, 1, GL_FALSE, world_from_mesh.data());
    glUniform3fv(base_colour_, 1, instruments_[t].colour.data());
    instruments_[t].mesh.Draw();
  }
}

}  // namespace hpdm
