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
