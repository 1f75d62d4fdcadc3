#include "engine/mesh/surface_mesh.h"

namespace hpdm {

void VertexNormals(const Points& vertices, const Triangles& triangles, Points* normals) {
  if (normals->rows() != vertices.rows()) normals->resize(vertices.rows(), 3);
  normals->setZero();
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector3d normal = TwiceAreaNormal(vertices, triangles, t);
    for (int k = 0; k < 3; ++k) normals->row(triangles(t, k)) += normal;
  }
  for (Eigen::Index v = 0; v < normals->rows(); ++v) {
    const double length = normals->row(v).norm();
    if (length > 0) normals->row(v) /= length;
  }
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
