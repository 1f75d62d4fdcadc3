// Darkens the colour a little where the surface turns away, so that its shape stays visible.
in vec3 p_W;
in vec3 normal_W;
in float value;
out vec4 colour;
void Paint(float mapped, float opacity) {
  float facing = abs(dot(normalize(normal_W), normalize(lens_W.xyz - p_W)));
  float outside = length(gl_FragCoord.xy - circle_px.xy) - circle_px.z;
  opacity *= clamp(0.5 - outside / circle_px.w, 0.0, 1.0);
  colour = vec4(MapColour(mapped) * mix(0.7, 1.0, facing), opacity);
}
