// The parts that all materials share. Colours are linear until Encode.
//
//   1. Irradiance at distance d: (d0 / d)^2 cos^2(theta), with d0 the target's distance (automatic
//      exposure) and theta the angle off the viewing axis. The light is at the scope's tip.
//   2. Tissue reflects diffusely, wrapped around the terminator by scattering under the surface
//      (red the most), and specularly as a wet film: GGX (Walter et al. 2007) with Schlick's
//      Fresnel term. Metal reflects a red surrounding.
//   3. The camera's tone curve and the optics' vignette follow.
//
// Everything depends on positions alone (no time, no random numbers): the same scene gives the same
// pixels. Needs frame.glsl.
// Returns the irradiance at p; to_light is the unit direction.
float Irradiance(vec3 p, out vec3 to_light) {
  vec3 d = light_W.xyz - p;
  float distance2 = max(dot(d, d), 1e-8);
  to_light = d * inversesqrt(distance2);
  float off_axis = max(-dot(to_light, axis_W.xyz), 0.0);
  return light_W.w / distance2 * off_axis * off_axis;
}

// GGX lobe without the Fresnel factor; its masking term is approximated by 1 / (l . h)^2 (Karis
// 2013). a2: the lobe's width squared.
float Lobe(float n_h, float l_h, float a2) {
  float k = n_h * n_h * (a2 - 1.0) + 1.0;
  return a2 / (12.566 * k * k * max(l_h * l_h, 0.1));
}

// Schlick's Fresnel factor.
float Fresnel(float f0, float l_h) {
  float x = 1.0 - l_h;
  return f0 + (1.0 - f0) * (x * x) * (x * x) * x;
}

// Applies the exposure and the camera's tone curve (a rational fit to film by Hejl and
// Burgess-Dawson, 2010, which includes the screen's gamma), the optics' vignette and the circle.
vec4 Encode(vec3 radiance) {
  vec3 x = max(radiance - 0.004, 0.0);
  vec3 c = (x * (6.2 * x + 0.5)) / (x * (6.2 * x + 1.7) + 0.06);
  vec2 from_centre = gl_FragCoord.xy - circle_px.xy;
  float r2 = dot(from_centre, from_centre) / (circle_px.z * circle_px.z);
  float outside = sqrt(r2) * circle_px.z - circle_px.z;
  return vec4(c * ((1.0 - 0.3 * r2 * r2) * clamp(0.5 - outside / circle_px.w, 0.0, 1.0)), 1.0);
}
