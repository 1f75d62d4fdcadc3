// Needs frame.glsl and light.glsl.
// Returns the light from tissue at p. All vectors are unit: n is the normal without, `rough` with
// the fine relief. spread: mean square of the slopes finer than a pixel.
vec3 ShadeTissue(vec3 p, vec3 to_lens, vec3 n, vec3 rough, float spread, vec3 albedo) {
  vec3 to_light;
  float irradiance = Irradiance(p, to_light);
  // Subsurface scattering reaches past the terminator, red the farthest, and blurs the relief.
  vec3 wrap = vec3(0.18, 0.05, 0.04);
  vec3 diffuse = max((dot(mix(n, rough, 0.75), to_light) + wrap) / (1.0 + wrap), 0.0);
  // Light reflected by other tissue.
  vec3 ambient = vec3(0.085, 0.038, 0.032) * (0.7 + 0.5 * n.z);
  // The liquid film: sharp glints that follow the relief, over a broad sheen.
  vec3 h = normalize(to_light + to_lens);
  float l_h = max(dot(to_light, h), 0.0);
  float film = max(dot(n, to_light), 0.0) * Fresnel(0.028, l_h) *
               (4.5 * Lobe(max(dot(rough, h), 0.0), l_h, 0.004 + spread) +
                1.9 * Lobe(max(dot(rough, h), 0.0), l_h, 0.10));
  return albedo * (1.4 * irradiance * diffuse + ambient) +
         irradiance * film * vec3(1.0, 0.96, 0.92);
}
