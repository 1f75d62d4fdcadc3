#include "engine/baselines/surface_error.h"

#include <cmath>

namespace hpdm {

double RelativeSurfaceError(const SurfaceMesh& rest, const Points& u, const Points& reference) {
  double error = 0, size = 0;
  for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
    const Vector3d a = rest.vertices.row(rest.triangles(t, 0)),
                   b = rest.vertices.row(rest.triangles(t, 1)),
                   c = rest.vertices.row(rest.triangles(t, 2));
    const double area = (b - a).cross(c - a).norm();  // twice; the factor cancels
    for (int k = 0; k < 3; ++k) {
      const int v = rest.triangles(t, k);
      error += area * (u.row(v) - reference.row(v)).squaredNorm();
      size += area * reference.row(v).squaredNorm();
    }
  }
  return std::sqrt(error / size);
}

double RelativeVolumeChange(const SurfaceMesh& rest, const Points& u) {
  return EnclosedVolume(rest.vertices + u, rest.triangles) /
             EnclosedVolume(rest.vertices, rest.triangles) -
         1;
}

}  // namespace hpdm
