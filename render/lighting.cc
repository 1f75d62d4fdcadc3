#include "render/lighting.h"

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

// A lobe of GGX about the normal: its density with the masking term approximated by 1 / (l . h)^2,
// without the Fresnel factor.
float Lobe(float n_h, float l_h, float roughness) {
  float a = roughness * roughness;
  float k = n_h * n_h * (a * a - 1.0) + 1.0;
  return a * a / (12.566 * k * k * max(l_h * l_h, 0.1));
}

// Schlick's Fresnel factor.
float Fresnel(float f0, float l_h) {
  float x = 1.0 - l_h;
  return f0 + (1.0 - f0) * (x * x) * (x * x) * x;
}

// Exposure, then the sRGB curve, then the circle.
vec4 Encode(vec3 radiance) {
  vec3 c = 1.0 - exp(-radiance);
  c = mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
  float outside = length(gl_FragCoord.xy - circle_px.xy) - circle_px.z;
  return vec4(c * clamp(0.5 - outside / circle_px.w, 0.0, 1.0), 1.0);
}
)glsl";

const char* const kPattern = R"glsl(
uint Mix(uint h) {
  h ^= h >> 15u;
  h *= 0x2c1b3c6du;
  h ^= h >> 12u;
  h *= 0x297a2d39u;
  return h ^ (h >> 15u);
}

float Lattice(uint h) { return float(Mix(h) >> 8u) * (1.0 / 16777216.0); }

// Value noise: a number in 0..1 at every integer point, blended with a quintic between them. The
// value in w, its gradient in xyz.
vec4 Noise(vec3 p) {
  vec3 cell = floor(p);
  vec3 f = p - cell;
  vec3 s = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
  vec3 ds = 30.0 * f * f * (f * (f - 2.0) + 1.0);
  uvec3 low = uvec3(ivec3(cell)) * uvec3(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
  uvec3 high = low + uvec3(0x8da6b343u, 0xd8163841u, 0xcb1ab31fu);
  // Corners (x, y) = (0, 0), (1, 0), (0, 1), (1, 1) of the cell's near and far side in z.
  vec4 near = vec4(Lattice(low.x ^ low.y ^ low.z), Lattice(high.x ^ low.y ^ low.z),
                   Lattice(low.x ^ high.y ^ low.z), Lattice(high.x ^ high.y ^ low.z));
  vec4 far = vec4(Lattice(low.x ^ low.y ^ high.z), Lattice(high.x ^ low.y ^ high.z),
                  Lattice(low.x ^ high.y ^ high.z), Lattice(high.x ^ high.y ^ high.z));
  vec4 in_z = mix(near, far, s.z);
  vec2 in_y = mix(in_z.xy, in_z.zw, s.y);
  vec4 z_slope = far - near;
  vec2 z_slope_in_y = mix(z_slope.xy, z_slope.zw, s.y);
  return vec4(ds.x * (in_y.y - in_y.x),
              ds.y * mix(in_z.z - in_z.x, in_z.w - in_z.y, s.x),
              ds.z * mix(z_slope_in_y.x, z_slope_in_y.y, s.x),
              mix(in_y.x, in_y.y, s.x));
}

// The unit normal n at p of a surface raised by a height whose gradient in the pattern's
// coordinates is `slope` (no unit): the slope along the picture's axes, carried over to the
// deformed surface (Mikkelsen 2010).
vec3 Bump(vec3 p, vec3 n, vec3 pattern, vec3 slope) {
  vec3 px = dFdx(p), py = dFdy(p);
  vec3 rx = cross(py, n), ry = cross(n, px);
  float area = dot(px, rx);
  vec3 along = sign(area) * (dot(slope, dFdx(pattern)) * rx + dot(slope, dFdy(pattern)) * ry);
  return normalize(abs(area) * n - along);
}
)glsl";

const char* const kTissue = R"glsl(
// p, normal: in the world; pattern: where in the tissue (m), so that the pattern moves with it;
// wetness: strength of the film, 1 for an organ.
vec3 ShadeTissue(vec3 p, vec3 normal, vec3 pattern, vec3 base, float wetness) {
  vec3 to_lens = normalize(lens_W.xyz - p);
  vec3 n = normalize(normal);
  n = faceforward(n, -to_lens, n);

  vec4 patches = Noise(pattern / 0.028);
  vec4 lobules = Noise(pattern / 0.0045 + 17.0);
  vec3 albedo = base * mix(0.72, 1.28, patches.w) * mix(0.86, 1.14, lobules.w);
  albedo.yz *= 1.0 - 0.3 * smoothstep(0.5, 0.8, patches.w);
  vec3 bumpy = Bump(p, n, pattern, 0.08 * lobules.xyz + 0.10 * patches.xyz);

  vec3 to_light;
  float irradiance = Irradiance(p, to_light);
  float open = Openness(p, n);
  vec3 wrap = vec3(0.16, 0.06, 0.05);
  vec3 diffuse = max((dot(bumpy, to_light) + wrap) / (1.0 + wrap), 0.0);
  // Light that other tissue sends back: red, and a little more from above.
  vec3 ambient = vec3(0.10, 0.05, 0.045) * (0.7 + 0.5 * n.z);
  // The film: sharp glints over a broad sheen.
  vec3 h = normalize(to_light + to_lens);
  float n_h = max(dot(bumpy, h), 0.0), l_h = max(dot(to_light, h), 0.0);
  float film = max(dot(bumpy, to_light), 0.0) * Fresnel(0.035, l_h) *
               (3.0 * Lobe(n_h, l_h, 0.27) + 4.0 * Lobe(n_h, l_h, 0.55));
  return (albedo * (1.25 * irradiance * diffuse + ambient) + wetness * irradiance * film) * open;
}
)glsl";

}  // namespace hpdm::glsl
