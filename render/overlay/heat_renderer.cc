#include "render/overlay/heat_renderer.h"

#include <epoxy/gl.h>

#include <string>

#include "render/camera/frame_uniforms.h"
#include "render/overlay/colour_map.h"
#include "render/shader_sources.h"

namespace hpdm {
HeatRenderer::HeatRenderer()
    : force_("force overlay", {glsl::kFrame, glsl::kOrganVertex},
             {glsl::kFrame, ColourMapGlsl().c_str(), glsl::kHeatPaint,
              ("#define MAX_SPOTS " + std::to_string(kMaxInstruments) + "\n").c_str(),
              glsl::kHeatForce}),
      vertex_heat_("error overlay", {glsl::kFrame, glsl::kOrganVertex},
                   {glsl::kFrame, ColourMapGlsl().c_str(), glsl::kHeatPaint, glsl::kHeatValues}),
      bar_("colour bar", {glsl::kFrame, glsl::kBarVertex},
           {ColourMapGlsl().c_str(), glsl::kBarFragment}),
      spot_count_(force_.Uniform("spot_count")),
      spots_(force_.Uniform("spots")),
      forces_(force_.Uniform("forces")),
      bar_place_(bar_.Uniform("place")) {
  force_.BindBlock("Frame", FrameBlock::kBinding);
  vertex_heat_.BindBlock("Frame", FrameBlock::kBinding);
  bar_.BindBlock("Frame", FrameBlock::kBinding);
}

void HeatRenderer::Begin() const {
  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  // Rounding in another program may place the same triangle slightly farther away.
  glEnable(GL_POLYGON_OFFSET_FILL);
  glPolygonOffset(-1, -4);
}

void HeatRenderer::End() const {
  glDisable(GL_POLYGON_OFFSET_FILL);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
}

void HeatRenderer::DrawForce(const MeshRenderer& mesh,
                             const std::array<ForceSpot, kMaxInstruments>& spots, int spot_count,
                             double full_scale) {
  std::array<Eigen::Vector4f, kMaxInstruments> places;
  std::array<float, kMaxInstruments> forces{};
  for (int i = 0; i < spot_count; ++i) {
    places[i] = WithW(spots[i].p_W, spots[i].radius);
    forces[i] = static_cast<float>(spots[i].force / full_scale);
  }
  if (spot_count == 0) return;
  force_.Use();
  glUniform1i(spot_count_, spot_count);
  glUniform4fv(spots_, spot_count, places[0].data());
  glUniform1fv(forces_, spot_count, forces.data());
  Begin();
  mesh.Draw();
  End();
}

void HeatRenderer::DrawVertexHeat(const MeshRenderer& mesh) {
  vertex_heat_.Use();
  Begin();
  mesh.Draw();
  End();
}

void HeatRenderer::DrawBar(int place) {
  bar_.Use();
  glUniform1f(bar_place_, static_cast<float>(place));
  glDisable(GL_DEPTH_TEST);
  glBindVertexArray(no_inputs_.name());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
  glEnable(GL_DEPTH_TEST);
}

}  // namespace hpdm
