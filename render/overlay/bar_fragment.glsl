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
