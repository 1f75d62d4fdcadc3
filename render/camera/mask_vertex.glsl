// Vertex pairs around the circle: even ones just outside its soft edge, odd ones outside the
// picture. Three more form the notch.
void main() {
  float angle = 6.2831853 * float(gl_VertexID / 2) / 96.0;
  // The chord of 1/96 of a turn runs inside its circle by less than 0.06 %.
  float radius = (circle_px.z + 0.5 * circle_px.w) * 1.001;
  radius = gl_VertexID % 2 == 0 ? radius : 2.0 * (circle_px.x + circle_px.y);
  vec2 from_centre = radius * vec2(cos(angle), sin(angle));
  if (gl_VertexID >= 194) {
    float side = float(gl_VertexID - 195);   // -1, 0, 1: left, apex, right
    from_centre = circle_px.z * vec2(0.028 * side, side == 0.0 ? 0.945 : 1.02);
  }
  gl_Position = vec4(from_centre / circle_px.xy, -1.0, 1.0);
}
