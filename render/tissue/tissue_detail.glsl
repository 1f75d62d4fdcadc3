// DetailAt() looks the relief up; Raised() turns a normal by its slope. For fragment stages.
uniform sampler2D tissue_detail;
const float kDetailTile = 0.064;   // as in tissue_detail.h
const float kDetailSlope = 0.5;

struct Detail {
  vec2 slope;
  float spread;   // mean square of the slopes that the mipmap averaged away
  float height;   // 0..1
};
// m: place on the tissue, in metres.
Detail DetailAt(vec2 m) {
  vec4 texel = texture(tissue_detail, m * (1.0 / kDetailTile));
  Detail detail;
  vec2 relative = 2.0 * texel.xy - 1.0;
  detail.slope = kDetailSlope * relative;
  detail.spread = kDetailSlope * kDetailSlope * max(texel.z - dot(relative, relative), 0.0);
  detail.height = texel.w;
  return detail;
}

// Returns the unit normal at p of a surface with normal n raised by a height, whose gradient in the
// coordinates m (m) is `slope`. The slope along the picture's axes is transferred to the deformed
// surface (Mikkelsen 2010).
vec3 Raised(vec3 p, vec3 n, vec2 m, vec2 slope) {
  vec3 px = dFdx(p), py = dFdy(p);
  vec3 rx = cross(py, n), ry = cross(n, px);
  float area = dot(px, rx);
  vec3 along = sign(area) * (dot(slope, dFdx(m)) * rx + dot(slope, dFdy(m)) * ry);
  return normalize(abs(area) * n - along);
}
