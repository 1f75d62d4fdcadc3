noperspective in vec2 at;
flat in vec2 from;
flat in vec2 to;
flat in vec2 radii;
flat in vec4 ink;
uniform float opacity;
out vec4 colour;
void main() {
  vec2 along = to - from;
  float share = clamp(dot(at - from, along) / max(dot(along, along), 1e-6), 0.0, 1.0);
  float outside = distance(at, mix(from, to, share)) - mix(radii.x, radii.y, share);
  float beyond_circle = distance(at, circle_px.xy) - circle_px.z;
  float covered = clamp(0.5 - outside, 0.0, 1.0) * clamp(0.5 - beyond_circle, 0.0, 1.0);
  colour = vec4(ink.rgb, opacity * ink.a * covered);
}
