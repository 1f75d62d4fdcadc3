in vec3 p_W;
in vec3 normal_W;
in vec2 uv;
in float rawness;
uniform vec3 base_colour;
uniform float metres_per_uv;
uniform sampler2D base_texture;
uniform sampler2D openness;   // by position in the picture
out vec4 colour;
void main() {
  vec3 to_lens = normalize(lens_W.xyz - p_W);
  vec3 n = normalize(normal_W);
  n = faceforward(n, -to_lens, n);
  vec2 m = metres_per_uv * uv;
  Detail detail = DetailAt(m);
  vec3 rough = Raised(p_W, n, m, detail.slope);
  vec3 albedo = base_colour * texture(base_texture, uv).rgb * (0.86 + 0.28 * detail.height);
  if (rawness > 0.0) {  // bleeding, in patches
    float patchy = clamp(min(rawness, 1.0) * (0.6 + 0.8 * detail.height), 0.0, 1.0);
    albedo = mix(albedo, vec3(0.22, 0.020, 0.016) * (0.7 + 0.6 * detail.height), 0.85 * patchy);
    float charred = clamp((rawness - 1.0) * (0.7 + 0.6 * detail.height), 0.0, 1.0);
    albedo = mix(albedo, vec3(0.035, 0.022, 0.014) * (0.5 + detail.height), 0.9 * charred);
  }
  float open = Openness(p_W, n) * (kShadows ? Unshadowed(p_W, n) : 1.0) *
               texture(openness, 0.5 * gl_FragCoord.xy / circle_px.xy).r;
  colour = Encode(ShadeTissue(p_W, to_lens, n, rough, detail.spread, albedo) * open);
}
