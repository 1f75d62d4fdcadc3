// The parts that all materials share. Colours are linear until Encode.
//
//   1. Irradiance at distance d: (d0 / d)^2 cos^2(theta), with d0 the target's distance (automatic
//      exposure) and theta the angle off the viewing axis. The light is at the scope's tip.
//   2. Tissue reflects diffusely, wrapped around the terminator by scattering under the surface
//      (red the most), and specularly as a wet film: GGX (Walter et al. 2007) with Schlick's
//      Fresnel term. Metal reflects a red surrounding.
//   3. The camera's tone curve and the optics' vignette follow.
//
// Everything depends on positions alone (no time, no random numbers): the same scene gives the same
// pixels. Needs frame.glsl.
// Returns the irradiance at p; to_light is the unit direction.
float Irradiance(vec3 p, out vec3 to_light) {
  vec3 d = light_W.xyz - p;
  float distance2 = max(dot(d, d), 1e-8);
  to_light = d * inversesqrt(distance2);
  float off_axis = max(-dot(to_light, axis_W.xyz), 0.0);
  return light_W.w / distance2 * off_axis * off_axis;
}

// Returns the share of ambient light and scope light that the instruments leave at p with normal n:
// an occluder of radius r at distance d hides about (r / d)^2.
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

// Returns the share of a lamp's light that the instruments let through to p with normal n. The
// lamp is a disc beside the scope, above it in the picture, as from a second light port. It is not
// drawn otherwise: the scope's own light casts shadows that its lens cannot see. The shadow lies
// below the tip in the picture, the farther the higher the tip is above the tissue, and joins it at
// the touch. An instrument of radius r whose axis the ray to the lamp passes at distance d, after a
// way s, blocks the part of [d - w, d + w] within [-r, r]; w = kLampWidth s is the half-width of the
// penumbra.
const float kLampHeight = 0.05;   // m above the lens
const float kLampWidth = 0.10;    // radius of the lamp over its distance
const float kShadow = 0.6;        // darkness of the full shadow
float Unshadowed(vec3 p, vec3 n) {
  vec3 to_lamp = lens_W.xyz + kLampHeight * normalize(up_W.xyz) - p;
  float lamp_distance = length(to_lamp);
  to_lamp /= lamp_distance;
  float facing = smoothstep(-0.1, 0.3, dot(n, to_lamp));
  float open = 1.0;
  for (int t = 0; t < kMaxTools; ++t) {
    if (tool_tip_W[t].w == 0.0) continue;
    vec3 a = tool_axis_W[t].xyz;
    vec3 d = p - tool_tip_W[t].xyz;
    // The axis's point closest to the ray, at `along` from the tip, then the ray's closest to it.
    float cosine = dot(to_lamp, a);
    float along = max((dot(a, d) - cosine * dot(to_lamp, d)) / max(1.0 - cosine * cosine, 1e-4),
                      0.0);
    vec3 to_axis = along * a - d;
    float s = max(dot(to_axis, to_lamp), 0.0);
    float radius = mix(tool_tip_W[t].w, tool_axis_W[t].w, clamp(along / 0.01, 0.0, 1.0));
    if (s > lamp_distance) continue;   // behind the lamp
    float w = max(kLampWidth * s, 5e-4);
    float off = length(s * to_lamp - to_axis);
    float blocked = smoothstep(-w, w, radius - off) - smoothstep(-w, w, -radius - off);
    open *= 1.0 - kShadow * facing * blocked;
  }
  return open;
}

// GGX lobe without the Fresnel factor; its masking term is approximated by 1 / (l . h)^2 (Karis
// 2013). a2: the lobe's width squared.
float Lobe(float n_h, float l_h, float a2) {
  float k = n_h * n_h * (a2 - 1.0) + 1.0;
  return a2 / (12.566 * k * k * max(l_h * l_h, 0.1));
}

// Schlick's Fresnel factor.
float Fresnel(float f0, float l_h) {
  float x = 1.0 - l_h;
  return f0 + (1.0 - f0) * (x * x) * (x * x) * x;
}

// Applies the exposure and the camera's tone curve (a rational fit to film by Hejl and
// Burgess-Dawson, 2010, which includes the screen's gamma), the optics' vignette and the circle.
vec4 Encode(vec3 radiance) {
  vec3 x = max(radiance - 0.004, 0.0);
  vec3 c = (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06);
  vec2 from_centre = gl_FragCoord.xy - circle_px.xy;
  float r2 = dot(from_centre, from_centre) / (circle_px.z * circle_px.z);
  float outside = sqrt(r2) * circle_px.z - circle_px.z;
  return vec4(c * ((1.0 - 0.3 * r2 * r2) * clamp(0.5 - outside / circle_px.w, 0.0, 1.0)), 1.0);
}
