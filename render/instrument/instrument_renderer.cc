#include "render/instrument/instrument_renderer.h"

#include <epoxy/gl.h>

#include <algorithm>
#include <cstddef>
#include <numbers>

#include "engine/base/check.h"
#include "render/instrument/capsule_mesh.h"
#include "render/instrument/drawn_pose.h"
#include "render/shader_sources.h"

namespace hpdm {
namespace {

constexpr double kCrease = std::numbers::pi / 5;  // rad: sharper edges of an instrument stay sharp
constexpr double kShaftLength = 0.40;             // m: longer than any insertion
constexpr double kBeyond = 1e3;                   // m: longer than any instrument

}  // namespace

Isometry3d PoseInTool(const InstrumentPart& part, double jaw) {
  const Eigen::Translation3d to_pivot(0, 0, part.pivot);
  return to_pivot * Eigen::AngleAxisd(-part.opening * jaw, Vector3d::UnitY()) * to_pivot.inverse();
}

InstrumentRenderer::InstrumentRenderer(const std::vector<InstrumentVisual>& instruments)
    : program_("instrument", {glsl::kFrame, glsl::kInstrumentVertex},
               {glsl::kFrame, glsl::kLight, glsl::kInstrumentFragment}),
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
                        .geometry = visual.geometry};
  for (const InstrumentPart& part : visual.parts) {
    instrument.parts.push_back({MeshRenderer(CutCreases(*part.mesh, kCrease)), part});
  }
  if (visual.parts.empty()) {
    const SurfaceMesh capsule =
        CapsuleMesh(visual.geometry.tip_radius, visual.geometry.shaft_radius, kShaftLength);
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

Isometry3d InstrumentRenderer::PoseOf(const SceneSnapshot& snapshot, int tool) const {
  const ToolPose& pose = snapshot.tools[tool];
  return DrawnPose(pose, snapshot.contacts[tool], Held(tool, pose).geometry.tip_radius);
}

void InstrumentRenderer::AddTo(const SceneSnapshot& snapshot, FrameUniforms* frame) const {
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const Isometry3d X_WT = PoseOf(snapshot, t);
    const Instrument& instrument = Held(t, snapshot.tools[t]);
    frame->tool_tip_W[t] = WithW(X_WT.translation(), instrument.geometry.tip_radius);
    frame->tool_axis_W[t] = WithW(X_WT.linear().col(2), instrument.geometry.shaft_radius);
  }
}

void InstrumentRenderer::Draw(const SceneSnapshot& snapshot) const {
  program_.Use();
  for (int t = 0; t < DrawnCount(snapshot); ++t) {
    const ToolPose& pose = snapshot.tools[t];
    const Isometry3d X_WT = PoseOf(snapshot, t);
    const Instrument& instrument = Held(t, pose);
    glUniform3fv(base_colour_, 1, instrument.colour.data());
    glUniform3fv(insulation_, 1, instrument.insulation.data());
    glUniform1f(insulated_from_, static_cast<float>(std::min(instrument.insulated_from, kBeyond)));
    for (const Part& part : instrument.parts) {
      const Isometry3d X_WP = X_WT * PoseInTool(part.placed, pose.jaw);
      const Eigen::Matrix4f world_from_mesh = X_WP.matrix().cast<float>();
      glUniformMatrix4fv(world_from_mesh_, 1, GL_FALSE, world_from_mesh.data());
      part.mesh.Draw();
    }
  }
}

}  // namespace hpdm
