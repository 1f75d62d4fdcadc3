// What the instruments take from the light on tissue. Needs frame.glsl and kTools, their number: a
// software renderer computes every turn of a loop for every pixel.
// Returns the share of ambient light and scope light that the instruments leave at p with normal n:
// an occluder of radius r at distance d hides about (r / d)^2.
float Openness(vec3 p, vec3 n) {
  float open = 1.0;
  for (int t = 0; t < kTools; ++t) {
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
  for (int t = 0; t < kTools; ++t) {
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
