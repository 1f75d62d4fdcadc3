layout(location = 0) in vec3 rest;
layout(location = 1) in vec3 rest_normal;
layout(location = 2) in vec3 unit;         // the rest point in the lattice's box, 0..1
uniform samplerBuffer shape;               // see UploadShape
uniform samplerBuffer sinking;             // KernelSinking
uniform mat3 unit_from_world;              // d unit / d rest, 1/m
uniform float sinking_tail;
uniform int active_count;
uniform int indentation_count;
uniform vec4 indentation_centre[MAX_INDENTATIONS];       // w: radius
uniform vec4 indentation_normal[MAX_INDENTATIONS];       // w: resolved radius
uniform vec4 indentation_amplitude[MAX_INDENTATIONS];     // w: reach
out vec3 position;
out vec3 normal;

// KernelSinking and its derivative.
vec2 Sinking(float s) {
  if (s >= SINKING_END) {
    float tail = sinking_tail / (s * s);
    return vec2(1.0 + tail, -(1.0 + 3.0 * tail) / s) / (3.14159265 * s);
  }
  float at = s * float(SINKING_INTERVALS) / SINKING_END;
  int i = min(int(at), SINKING_INTERVALS - 1);
  float low = texelFetch(sinking, i).x, high = texelFetch(sinking, i + 1).x;
  return vec2(low + (at - float(i)) * (high - low),
              (high - low) * float(SINKING_INTERVALS) / SINKING_END);
}

void main() {
  vec3 u = vec3(0.0);
  mat3 by_unit = mat3(0.0);                // du / d unit
  float nx[SUPPORT], ny[SUPPORT], nz[SUPPORT], dx[SUPPORT], dy[SUPPORT], dz[SUPPORT];
  ivec3 first = ivec3(Evaluate(unit.x, DEGREES.x, CELLS.x, nx, dx),
                      Evaluate(unit.y, DEGREES.y, CELLS.y, ny, dy),
                      Evaluate(unit.z, DEGREES.z, CELLS.z, nz, dz));
  for (int i = 0; i <= DEGREES.x; ++i) {
    vec3 u_yz = vec3(0.0), u_y_z = vec3(0.0), u_yz_ = vec3(0.0);  // sum, d/dy, d/dz
    for (int j = 0; j <= DEGREES.y; ++j) {
      vec3 u_z = vec3(0.0), u_z_ = vec3(0.0);
      int row = ((first.x + i) * COUNTS.y + first.y + j) * COUNTS.z + first.z;
      for (int k = 0; k <= DEGREES.z; ++k) {
        vec3 U = texelFetch(shape, row + k).xyz;
        u_z += nz[k] * U;
        u_z_ += dz[k] * U;
      }
      u_yz += ny[j] * u_z;
      u_y_z += dy[j] * u_z;
      u_yz_ += ny[j] * u_z_;
    }
    u += nx[i] * u_yz;
    by_unit[0] += dx[i] * u_yz;
    by_unit[1] += nx[i] * u_y_z;
    by_unit[2] += nx[i] * u_yz_;
  }

  if (active_count > 0) {
    first = ivec3(Evaluate(unit.x, DEGREES.x, FINER_CELLS.x, nx, dx),
                  Evaluate(unit.y, DEGREES.y, FINER_CELLS.y, ny, dy),
                  Evaluate(unit.z, DEGREES.z, FINER_CELLS.z, nz, dz));
    for (int a = 0; a < active_count; ++a) {
      int entry = COUNTS.x * COUNTS.y * COUNTS.z + 2 * a;
      ivec3 at = ivec3(texelFetch(shape, entry).xyz) - first;
      if (any(lessThan(at, ivec3(0))) || any(greaterThan(at, DEGREES))) continue;
      vec3 U = texelFetch(shape, entry + 1).xyz;
      u += nx[at.x] * ny[at.y] * nz[at.z] * U;
      by_unit[0] += dx[at.x] * ny[at.y] * nz[at.z] * U;
      by_unit[1] += nx[at.x] * dy[at.y] * nz[at.z] * U;
      by_unit[2] += nx[at.x] * ny[at.y] * dz[at.z] * U;
    }
  }
  mat3 F = mat3(1.0) + by_unit * unit_from_world;

  for (int i = 0; i < indentation_count; ++i) {
    vec3 from_centre = rest - indentation_centre[i].xyz;
    float d = length(from_centre);
    if (d >= indentation_amplitude[i].w ||
        dot(rest_normal, indentation_normal[i].xyz) <= 0.0) continue;
    float radius = indentation_centre[i].w, resolved = indentation_normal[i].w;
    vec2 near = Sinking(d / radius) / radius, far = Sinking(d / resolved) / resolved;
    u += (near.x - far.x) * indentation_amplitude[i].xyz;
    float slope = near.y / radius - far.y / resolved;
    F += outerProduct(indentation_amplitude[i].xyz, slope / max(d, 1e-9) * from_centre);
  }

  position = rest + u;
  mat3 cofactors = mat3(cross(F[1], F[2]), cross(F[2], F[0]), cross(F[0], F[1]));
  vec3 n = cofactors * rest_normal;
  normal = n * inversesqrt(max(dot(n, n), 1e-30));
}
