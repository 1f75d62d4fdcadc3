// Draws dark folds instead of a picture: the relief of tissue at two coarse scales, laid on the
// sphere stereographically from behind the first lens.
uniform mat3 camera_from_world;   // the first frame's
void main() {
  vec3 p = WallPoint();
  vec3 inwards = (sphere_W.xyz - p) / sphere_W.w;
  vec3 d = camera_from_world * -inwards;
  vec2 m = 2.0 * sphere_W.w * d.xy / max(1.0 - d.z, 0.05);
  Detail folds = DetailAt(0.30 * m);
  Detail grain = DetailAt(1.7 * m);
  vec3 n = inwards;
  vec3 rough = Raised(p, n, m, folds.slope + 0.5 * grain.slope);
  vec3 base = mix(vec3(0.17, 0.035, 0.028), vec3(0.30, 0.11, 0.07), folds.height);
  vec3 to_lens = normalize(lens_W.xyz - p);
  colour = Encode(0.6 * ShadeTissue(p, to_lens, n, rough, 0.1 + folds.spread + grain.spread, base));
}
