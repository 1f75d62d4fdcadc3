layout(location = 0) in vec2 at_px;
layout(location = 1) in vec2 atlas_px;
layout(location = 2) in vec4 colour;
uniform vec2 picture_size;
uniform vec2 atlas_size;
out vec2 atlas_place;
out vec4 text_colour;
void main() {
  atlas_place = atlas_px / atlas_size;
  text_colour = colour;
  vec2 clip = 2.0 * at_px / picture_size - 1.0;
  gl_Position = vec4(clip.x, -clip.y, 0.0, 1.0);
}
