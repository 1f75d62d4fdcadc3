// Finds the point where the lens's ray meets the wall.
in vec3 ray_W;
uniform vec4 sphere_W;   // centre, radius
out vec4 colour;
vec3 WallPoint() {
  vec3 ray = normalize(ray_W);
  vec3 from_centre = lens_W.xyz - sphere_W.xyz;
  float b = dot(from_centre, ray);
  float c = dot(from_centre, from_centre) - sphere_W.w * sphere_W.w;
  return lens_W.xyz + (sqrt(max(b * b - c, 0.0)) - b) * ray;
}
