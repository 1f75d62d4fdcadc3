#include "engine/mesh/surface_mesh.h"

#include "engine/mesh/vertex_normals.h"

namespace hpdm {

void VertexNormals(const Points& vertices, const Triangles& triangles, Points* normals) {
  SetVertexNormals(vertices, triangles, normals);
}

double EnclosedVolume(const Points& vertices, const Triangles& triangles) {
  if (vertices.rows() == 0) return 0;
  const Vector3d origin = vertices.row(0);
  double six_volumes = 0;
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector3d a = vertices.row(triangles(t, 0)).transpose() - origin;
    const Vector3d b = vertices.row(triangles(t, 1)).transpose() - origin;
    const Vector3d c = vertices.row(triangles(t, 2)).transpose() - origin;
    six_volumes += a.dot(b.cross(c));
  }
  return six_volumes / 6;
}

Vector3d EnclosedCentre(const Points& vertices, const Triangles& triangles) {
  const Vector3d origin = vertices.row(0);
  double six_volumes = 0;
  Vector3d moment = Vector3d::Zero();  // 4 x centroid x 6 x volume, summed over the tetrahedra
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector3d a = vertices.row(triangles(t, 0)).transpose() - origin;
    const Vector3d b = vertices.row(triangles(t, 1)).transpose() - origin;
    const Vector3d c = vertices.row(triangles(t, 2)).transpose() - origin;
    const double six_volume = a.dot(b.cross(c));
    six_volumes += six_volume;
    moment += six_volume * (a + b + c);
  }
  return origin + moment / (4 * six_volumes);
}

}  // namespace hpdm
