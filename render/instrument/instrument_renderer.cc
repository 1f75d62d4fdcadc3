#include "render/instrument/instrument_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "engine/base/check.h"
#include "render/instrument/capsule_mesh.h"
#include "render/tissue/lighting.h"

namespace hpdm {
namespace {

constexpr double kCrease = std::numbers::pi / 5;  // rad: sharper edges of an instrument stay sharp
constexpr double kShaftLength = 0.40;             // m: longer than any insertion
constexpr double kBeyond = 1e3;                   // m: no instrument is as long

constexpr const char* kInstrumentVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
uniform mat4 world_from_mesh;   // rigid
out vec3 p_W;
out vec3 normal_W;
out float along;                // z in the tool frame, jaws closed
void main() {
  along = position.z;
  vec4 p = world_from_mesh * vec4(position, 1.0);
  p_W = p.xyz;
  normal_W = mat3(world_from_mesh) * normal;
  gl_Position = clip_from_world * p;
}
)glsl";

constexpr const char* kInstrumentFragment = R"glsl(
in vec3 p_W;
in vec3 normal_W;
in float along;
uniform vec3 base_colour;
uniform vec3 insulation;
uniform float insulated_from;
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
  float n_h = max(dot(n, h), 0.0);
  // Steel colours what it mirrors; insulation is a plastic with a colourless gloss.
  vec3 steel = base_colour * (0.28 * irradiance * n_l * n_l + surrounding) +
               base_colour * 2.5 * irradiance * n_l * Fresnel(0.6, l_h) * Lobe(n_h, l_h, 0.017);
  float grazing = pow(1.0 - max(dot(n, to_lens), 0.0), 5.0);
  vec3 plastic = insulation * irradiance * n_l + surrounding * (0.04 + 0.5 * grazing) +
                 vec3(2.5 * irradiance * n_l * Fresnel(0.04, l_h) * Lobe(n_h, l_h, 0.026));
  float edge = max(fwidth(along), 1e-6);
  vec3 radiance = mix(steel, plastic, smoothstep(-edge, edge, along - insulated_from));
  colour = Encode(radiance);
}
)glsl";

}  // namespace

Isometry3d PoseInTool(const InstrumentPart& part, double jaw) {
  const Eigen::Translation3d to_pivot(0, 0, part.pivot);
  return to_pivot * Eigen::AngleAxisd(-part.opening * jaw, Vector3d::UnitY()) * to_pivot.inverse();
}

InstrumentRenderer::InstrumentRenderer(const std::vector<InstrumentVisual>& instruments)
    : program_("instrument", {glsl::kFrame, kInstrumentVertex},
               {glsl::kFrame, glsl::kLight, kInstrumentFragment}),
      world_from_mesh_(program_.Uniform("world_from_mesh")),
      base_colour_(program_.Uniform("base_colour")),
      insulation_(program_.Uniform("insulation")),
      insulated_from_(program_.Uniform("insulated_from")) {
  HPDM_CHECK(instruments.size() <= kMaxInstruments);
  program_.BindBlock("Frame", FrameBlock::kBinding);
  instruments_.reserve(instruments.size());
  for (const InstrumentVisual& visual : instruments) {
    std::vector<Instrument>& held = instruments_.emplace_back();
    held.push_back(Upload(visual));
    for (const InstrumentVisual& other : visual.exchanges) held.push_back(Upload(other));
  }
}

InstrumentRenderer::Instrument InstrumentRenderer::Upload(const InstrumentVisual& visual) {
  Instrument instrument{.parts = {},
                        .colour = Linear(visual.colour),
                        .insulation = Linear(visual.insulation),
                        .insulated_from = visual.insulated_from,
                        .tip_radius = visual.tip_radius,
                        .shaft_radius = visual.shaft_radius};
  for (const InstrumentPart& part : visual.parts) {
    instrument.parts.push_back({MeshRenderer(CutCreases(*part.mesh, kCrease)), part});
  }
  if (visual.parts.empty()) {
    const SurfaceMesh capsule = CapsuleMesh(visual.tip_radius, visual.shaft_radius, kShaftLength);
    instrument.parts.push_back({MeshRenderer(CutCreases(capsule, kCrease)), {}});
  }
  return instrument;
}

int InstrumentRenderer::DrawnCount(const SceneSnapshot& snapshot) const {
  return std::min(static_cast<int>(instruments_.size()), snapshot.tool_count);
}

const InstrumentRenderer::Instrument& InstrumentRenderer::Held(int tool,
                                                               const ToolPose& pose) const {
  const std::vector<Instrument>& held = instruments_[tool];
  const auto instrument_index = static_cast<std::size_t>(pose.instrument_index);
  return held[instrument_index < held.size() ? instrument_index : 0];
}

void InstrumentRenderer::AddTo(const SceneSnapshot& snapshot, FrameUniforms* frame) const {
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const Isometry3d& X_WT = snapshot.tools[t].X_WT;
    const Instrument& instrument = Held(t, snapshot.tools[t]);
    frame->tool_tip_W[t] = WithW(X_WT.translation(), instrument.tip_radius);
    frame->tool_axis_W[t] = WithW(X_WT.linear().col(2), instrument.shaft_radius);
  }
}

void InstrumentRenderer::Draw(const SceneSnapshot& snapshot) const {
  program_.Use();
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const ToolPose& pose = snapshot.tools[t];
    const Instrument& instrument = Held(t, pose);
    glUniform3fv(base_colour_, 1, instrument.colour.data());
    glUniform3fv(insulation_, 1, instrument.insulation.data());
    glUniform1f(insulated_from_, static_cast<float>(std::min(instrument.insulated_from, kBeyond)));
    for (const Part& part : instrument.parts) {
      const Isometry3d X_WP = pose.X_WT * PoseInTool(part.placed, pose.jaw);
      const Eigen::Matrix4f world_from_mesh = X_WP.matrix().cast<float>();
      glUniformMatrix4fv(world_from_mesh_, 1, GL_FALSE, world_from_mesh.data());
      part.mesh.Draw();
    }
  }
}

}  // namespace hpdm
