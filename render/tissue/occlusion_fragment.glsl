uniform sampler2D depth;
uniform vec2 inverse_depth;   // 1 / z = x + y * depth, 1/m
uniform vec3 sampling;        // radius: px times m, m; strength
out float open;

// Eight directions on two circles, each sampled with its opposite.
const vec2 kOffsets[8] = vec2[8](
    vec2(1.0, 0.0), vec2(0.7071, 0.7071), vec2(0.0, 1.0), vec2(-0.7071, 0.7071),
    vec2(0.416, 0.172), vec2(0.172, 0.416), vec2(-0.172, 0.416), vec2(-0.416, 0.172));

// Enclosure by a neighbour s radii in front. One behind (s < 0) balances one in front on the other
// side.
float Enclosure(float s) { return clamp(s, -1.0, 1.0) * clamp(2.5 - 0.5 * s, 0.0, 1.0); }

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy);
  float at = texelFetch(depth, here, 0).r;
  if (at == 1.0) {
    open = 1.0;
    return;
  }
  ivec2 last = textureSize(depth, 0) - 1;
  float w = inverse_depth.x + inverse_depth.y * at;
  float radius_px = min(sampling.x * w, 32.0);
  float to_radii = inverse_depth.y / (w * w * sampling.y);
  float sum = 0.0;
  for (int i = 0; i < 8; ++i) {
    ivec2 offset = ivec2(round(radius_px * kOffsets[i]));
    float a = texelFetch(depth, clamp(here + offset, ivec2(0), last), 0).r;
    float b = texelFetch(depth, clamp(here - offset, ivec2(0), last), 0).r;
    sum += max(Enclosure((a - at) * to_radii) + Enclosure((b - at) * to_radii), 0.0);
  }
  open = max(1.0 - sampling.z * (0.5 / 8.0) * sum, 0.0);
}
