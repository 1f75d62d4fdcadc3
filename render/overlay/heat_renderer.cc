#include "render/overlay/heat_renderer.h"

#include <epoxy/gl.h>

#include <string>

#include "render/camera/frame_uniforms.h"
#include "render/overlay/colour_map.h"

namespace hpdm {
namespace {

constexpr const char* kHeatVertex = R"glsl(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 offset;
layout(location = 4) in float heat;
out vec3 p_W;
out vec3 normal_W;
out float value;
void main() {
  p_W = position + offset;
  normal_W = normal;
  value = heat;
  gl_Position = clip_from_world * vec4(p_W, 1.0);
}
)glsl";

// A little darker where the surface turns away, so that its shape stays visible.
constexpr const char* kPaint = R"glsl(
in vec3 p_W;
in vec3 normal_W;
in float value;
out vec4 colour;
void Paint(float mapped, float opacity) {
  float facing = abs(dot(normalize(normal_W), normalize(lens_W.xyz - p_W)));
  float outside = length(gl_FragCoord.xy - circle_px.xy) - circle_px.z;
  opacity *= clamp(0.5 - outside / circle_px.w, 0.0, 1.0);
  colour = vec4(MapColour(mapped) * mix(0.7, 1.0, facing), opacity);
}
)glsl";

constexpr const char* kForce = R"glsl(
uniform int spot_count;
uniform vec4 spots[2];    // position, radius
uniform float forces[2];  // over the full scale
void main() {
  float sum = 0.0, weights = 0.0, kernel = 0.0;
  for (int i = 0; i < spot_count; ++i) {
    float k = cos(1.5707963 * min(distance(p_W, spots[i].xyz) / spots[i].w, 1.0));
    sum += k * forces[i];
    weights += k;
    kernel = max(kernel, k);
  }
  if (kernel <= 0.001) discard;
  Paint(sum / weights, 0.95 * smoothstep(0.0, 0.8, kernel));
}
)glsl";
static_assert(kMaxInstruments == 2, "spots and forces in the shader");

constexpr const char* kVertexHeat = R"glsl(
void main() { Paint(value, 0.92); }
)glsl";

constexpr const char* kBarVertex = R"glsl(
uniform float place;
out vec2 at;              // 0..1 along and across the bar
void main() {
  at = vec2(float(gl_VertexID & 1), float(gl_VertexID / 2));
  // In pixels; the picture is twice the circle's centre.
  vec2 size = vec2(12.0, max(40.0, 0.5 * circle_px.y));
  vec2 low = vec2(2.0 * circle_px.x - 16.0 - size.x - place * (size.x + 10.0),
                  circle_px.y - 0.5 * size.y);
  gl_Position = vec4((low + at * size) / circle_px.xy - 1.0, -1.0, 1.0);
}
)glsl";

constexpr const char* kBarFragment = R"glsl(
in vec2 at;
out vec4 colour;
void main() {
  vec2 px = fwidth(at);
  vec2 from_edge = min(at, 1.0 - at) / px;
  float quarter = abs(fract(4.0 * at.y + 0.5) - 0.5) / (4.0 * px.y);
  bool tick = quarter < 0.7 && (at.x < 0.25 || at.x > 0.75);
  bool white = min(from_edge.x, from_edge.y) < 1.0 || tick;
  colour = vec4(white ? vec3(0.9) : MapColour(at.y), 1.0);
}
)glsl";

}  // namespace

HeatRenderer::HeatRenderer()
    : force_("force overlay", {glsl::kFrame, kHeatVertex},
             {glsl::kFrame, ColourMapGlsl().c_str(), kPaint, kForce}),
      vertex_heat_("error overlay", {glsl::kFrame, kHeatVertex},
                   {glsl::kFrame, ColourMapGlsl().c_str(), kPaint, kVertexHeat}),
      bar_("colour bar", {glsl::kFrame, kBarVertex}, {ColourMapGlsl().c_str(), kBarFragment}),
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
  // Another program may place the same triangle a rounding error farther away.
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
