// Smooths edges (FXAA): the brightness of the four diagonal neighbours gives the strength and the
// direction of the edge through a pixel. The pixel becomes the mean of samples along the edge, or
// of near samples only if the far ones belong to something else.
in vec2 place;
uniform sampler2D picture;
out vec4 colour;
float Brightness(vec3 c) { return dot(c, vec3(0.4, 0.5, 0.1)); }
float BrightnessAt(ivec2 pixel) { return Brightness(texelFetch(picture, pixel, 0).rgb); }
vec3 At(vec2 where) { return textureLod(picture, where, 0.0).rgb; }
void main() {
  vec2 size = vec2(textureSize(picture, 0));
  vec3 here = At(place);
  float b = Brightness(here);
  ivec2 pixel = clamp(ivec2(place * size), ivec2(1), ivec2(size) - 2);
  float b00 = BrightnessAt(pixel + ivec2(-1, -1));
  float b10 = BrightnessAt(pixel + ivec2(1, -1));
  float b01 = BrightnessAt(pixel + ivec2(-1, 1));
  float b11 = BrightnessAt(pixel + ivec2(1, 1));
  float darkest = min(b, min(min(b00, b10), min(b01, b11)));
  float brightest = max(b, max(max(b00, b10), max(b01, b11)));
  colour = vec4(here, 1.0);
  if (brightest - darkest < max(0.035, 0.15 * brightest)) return;
  vec2 along = vec2(b01 + b11 - b00 - b10, b00 + b01 - b10 - b11);
  float least = min(abs(along.x), abs(along.y)) + 0.03 * (b00 + b10 + b01 + b11) + 0.008;
  vec2 stride = clamp(along / least, -6.0, 6.0) / size;
  vec3 near = 0.5 * (At(place - stride / 6.0) + At(place + stride / 6.0));
  vec3 far = 0.5 * near + 0.25 * (At(place - 0.5 * stride) + At(place + 0.5 * stride));
  float b_far = Brightness(far);
  colour.rgb = b_far < darkest || b_far > brightest ? near : far;
}
