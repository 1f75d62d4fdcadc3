layout(location = 0) in vec4 a;       // position in the world, radius in pixels
layout(location = 1) in vec4 b;
layout(location = 2) in vec4 paint;   // colour as on a screen, opacity
noperspective out vec2 at;            // px
flat out vec2 from;
flat out vec2 to;
flat out vec2 radii;
flat out vec4 ink;
uniform float fade_from;      // m

const float kNear = 0.002;            // m, Laparoscope::kNear
const float kLift = 0.001;            // m towards the lens, so that surfaces do not hide marks

vec4 Clip(vec3 p) {
  return clip_from_world * vec4(p + kLift * normalize(lens_W.xyz - p), 1.0);
}

// A rectangle around the stroke.
void main() {
  vec4 clip_a = Clip(a.xyz), clip_b = Clip(b.xyz);
  ink = paint;
  radii = vec2(a.w, b.w);
  if (max(clip_a.w, clip_b.w) <= kNear) {   // behind the lens
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
  // The part in front of the lens.
  if (clip_a.w < kNear) clip_a = mix(clip_b, clip_a, (clip_b.w - kNear) / (clip_b.w - clip_a.w));
  if (clip_b.w < kNear) clip_b = mix(clip_a, clip_b, (clip_a.w - kNear) / (clip_a.w - clip_b.w));
  float beyond = 0.5 * (clip_a.w + clip_b.w) / fade_from - 1.0;
  ink.a *= clamp(1.0 - 2.0 * beyond, 0.2, 1.0);
  from = (clip_a.xy / clip_a.w + 1.0) * circle_px.xy;
  to = (clip_b.xy / clip_b.w + 1.0) * circle_px.xy;
  vec2 along = to - from;
  along = dot(along, along) > 1e-8 ? normalize(along) : vec2(1.0, 0.0);
  float r = max(a.w, b.w) + 1.0;
  bool at_b = (gl_VertexID & 1) == 1;
  vec2 across = ((gl_VertexID & 2) == 2 ? r : -r) * vec2(-along.y, along.x);
  at = (at_b ? to + r * along : from - r * along) + across;
  float depth = at_b ? clip_b.z / clip_b.w : clip_a.z / clip_a.w;
  gl_Position = vec4(at / circle_px.xy - 1.0, depth, 1.0);
}
