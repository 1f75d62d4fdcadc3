uniform vec3 circle;        // radius in the picture's half width and half height; rings
uniform float distortion;
out vec2 place;
// One strip per ring: even vertices on its inner, odd ones on its outer circle. In radii of the
// circle.
void main() {
  float ring = float(gl_InstanceID + gl_VertexID % 2);
  float r = 1.02 * ring / circle.z;   // to the end of the soft edge
  float angle = 6.2831853 * float(gl_VertexID / 2) / 48.0;
  vec2 direction = circle.xy * vec2(cos(angle), sin(angle));
  place = 0.5 + 0.5 * r * direction;
  gl_Position = vec4(r * (1.0 + distortion * r * r) / (1.0 + distortion) * direction, 0.0, 1.0);
}
