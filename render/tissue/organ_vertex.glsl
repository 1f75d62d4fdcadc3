layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec3 offset;
layout(location = 3) in vec2 texture_coordinate;
layout(location = 4) in float heat;  // overlays only
layout(location = 5) in float raw;   // torn surface, 0..1, charred up to 2
out vec3 p_W;
out vec3 normal_W;
out vec2 uv;
out float value;
out float rawness;
void main() {
  p_W = position + offset;
  normal_W = normal;
  uv = texture_coordinate;
  value = heat;
  rawness = raw;
  gl_Position = clip_from_world * vec4(p_W, 1.0);
}
