in vec3 p_W;
in vec3 normal_W;
in float along;
uniform vec3 base_colour;
uniform vec3 insulation;
uniform float insulated_from;
out vec4 colour;
void main() {
  vec3 to_lens = normalize(lens_W.xyz - p_W);
  vec3 n = normalize(normal_W);
  n = faceforward(n, -to_lens, n);
  vec3 to_light;
  float irradiance = Irradiance(p_W, to_light);
  float n_l = max(dot(n, to_light), 0.0);
  // The mirrored surrounding is red tissue, lit where the mirrored ray runs along the light.
  vec3 mirrored = reflect(-to_lens, n);
  float lit = 0.5 + 0.5 * dot(mirrored, axis_W.xyz);
  vec3 surrounding = mix(vec3(0.03, 0.015, 0.015), vec3(0.16, 0.11, 0.10), lit * lit);
  vec3 h = normalize(to_light + to_lens);
  float l_h = max(dot(to_light, h), 0.0);
  float n_h = max(dot(n, h), 0.0);
  // Steel tints its reflections; insulation is a plastic with a colourless gloss.
  vec3 steel = base_colour * (0.28 * irradiance * n_l * n_l + surrounding) +
               base_colour * 2.5 * irradiance * n_l * Fresnel(0.6, l_h) * Lobe(n_h, l_h, 0.017);
  float grazing = pow(1.0 - max(dot(n, to_lens), 0.0), 5.0);
  vec3 plastic = insulation * irradiance * n_l + surrounding * (0.04 + 0.5 * grazing) +
                 vec3(2.5 * irradiance * n_l * Fresnel(0.04, l_h) * Lobe(n_h, l_h, 0.026));
  float edge = max(fwidth(along), 1e-6);
  vec3 radiance = mix(steel, plastic, smoothstep(-edge, edge, along - insulated_from));
  colour = Encode(radiance);
}
