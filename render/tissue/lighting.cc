#include "render/tissue/lighting.h"

namespace hpdm::glsl {

const char* const kLight = R"glsl(
// Of the light at p: to_light is the unit direction.
float Irradiance(vec3 p, out vec3 to_light) {
  vec3 d = light_W.xyz - p;
  float distance2 = max(dot(d, d), 1e-8);
  to_light = d * inversesqrt(distance2);
  float off_axis = max(-dot(to_light, axis_W.xyz), 0.0);
  return light_W.w / distance2 * off_axis * off_axis;
}

// How open p with normal n lies to light that comes from everywhere and from the scope, with the
// instruments in the way: an occluder of radius r at distance d hides about (r / d)^2 of it.
float Openness(vec3 p, vec3 n) {
  float open = 1.0;
  for (int t = 0; t < kMaxTools; ++t) {
    vec3 d = p - tool_tip_W[t].xyz;
    float along = max(dot(d, tool_axis_W[t].xyz), 0.0);
    vec3 to_tool = along * tool_axis_W[t].xyz - d;
    float distance2 = max(dot(to_tool, to_tool), 1e-8);
    float radius = along > 0.0 ? tool_axis_W[t].w : tool_tip_W[t].w;
    float facing = clamp(0.5 + 0.5 * dot(n, to_tool) * inversesqrt(distance2), 0.0, 1.0);
    open *= 1.0 - 0.75 * facing * min(2.0 * radius * radius / distance2, 1.0);
  }
  return open;
}

// GGX about a normal, its masking term approximated by 1 / (l . h)^2 (Karis 2013), without the
// Fresnel factor; a2: its width squared.
float Lobe(float n_h, float l_h, float a2) {
  float k = n_h * n_h * (a2 - 1.0) + 1.0;
  return a2 / (12.566 * k * k * max(l_h * l_h, 0.1));
}

// Schlick's Fresnel factor.
float Fresnel(float f0, float l_h) {
  float x = 1.0 - l_h;
  return f0 + (1.0 - f0) * (x * x) * (x * x) * x;
}

// Exposure and the camera's tone curve (a rational fit to film by Hejl and Burgess-Dawson, 2010,
// with the screen's gamma in it), then what the optics lose towards the edge, then the circle.
vec4 Encode(vec3 radiance) {
  vec3 x = max(radiance - 0.004, 0.0);
  vec3 c = (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06);
  vec2 from_centre = gl_FragCoord.xy - circle_px.xy;
  float r2 = dot(from_centre, from_centre) / (circle_px.z * circle_px.z);
  float outside = sqrt(r2) * circle_px.z - circle_px.z;
  return vec4(c * ((1.0 - 0.3 * r2 * r2) * clamp(0.5 - outside / circle_px.w, 0.0, 1.0)), 1.0);
}
)glsl";

const char* const kTissue = R"glsl(
// Light from tissue at p, unit vectors throughout: n the normal without and `rough` with the fine
// relief; spread: mean square of the slopes finer than a pixel.
vec3 ShadeTissue(vec3 p, vec3 to_lens, vec3 n, vec3 rough, float spread, vec3 albedo) {
  vec3 to_light;
  float irradiance = Irradiance(p, to_light);
  // Light that enters here and leaves there: it reaches past the terminator, red the farthest, and
  // blurs the relief.
  vec3 wrap = vec3(0.18, 0.05, 0.04);
  vec3 diffuse = max((dot(mix(n, rough, 0.75), to_light) + wrap) / (1.0 + wrap), 0.0);
  // Light that other tissue sends back.
  vec3 ambient = vec3(0.085, 0.038, 0.032) * (0.7 + 0.5 * n.z);
  // The film of liquid: sharp glints that follow the relief over a broad sheen.
  vec3 h = normalize(to_light + to_lens);
  float l_h = max(dot(to_light, h), 0.0);
  float film = max(dot(n, to_light), 0.0) * Fresnel(0.028, l_h) *
               (4.5 * Lobe(max(dot(rough, h), 0.0), l_h, 0.004 + spread) +
                1.9 * Lobe(max(dot(rough, h), 0.0), l_h, 0.10));
  return albedo * (1.4 * irradiance * diffuse + ambient) + irradiance * film * vec3(1.0, 0.96, 0.92);
}
)glsl";

}  // namespace hpdm::glsl
