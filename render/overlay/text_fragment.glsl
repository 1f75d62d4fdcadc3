in vec2 atlas_place;
in vec4 text_colour;
uniform sampler2D coverage;
out vec4 colour;
void main() {
  colour = vec4(text_colour.rgb, text_colour.a * texture(coverage, atlas_place).r);
}
