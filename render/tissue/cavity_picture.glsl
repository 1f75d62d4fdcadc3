uniform sampler2D background;
uniform mat3 slide_from_world;   // turns into the projector's camera frame, x and y in slides
uniform vec3 projector_W;
void main() {
  vec3 p = WallPoint();
  vec3 d = slide_from_world * normalize(p - projector_W);
  // Beyond 70 degrees off its axis, outside of the first picture, the slide bends back.
  vec2 slide = 0.5 + 0.5 * d.xy / max(-d.z, 0.34);
  vec3 to_light;
  float irradiance = Irradiance(p, to_light);
  colour = Encode(2.0 * irradiance * texture(background, slide).rgb);
}
