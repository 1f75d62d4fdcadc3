#include "engine/mesh/surface_mesh.h"

namespace hpdm {

void VertexNormals(const Points& vertices, const Triangles& triangles, Points* normals) {
  if (normals->rows() != vertices.rows()) normals->resize(vertices.rows(), 3);
  normals->setZero();
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const int i = triangles(t, 0), j = triangles(t, 1), k = triangles(t, 2);
    const Vector3d a = vertices.row(i), b = vertices.row(j), c = vertices.row(k);
    const Vector3d twice_area_normal = (b - a).cross(c - a);
    normals->row(i) += twice_area_normal;
    normals->row(j) += twice_area_normal;
    normals->row(k) += twice_area_normal;
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
  Vector3d moment = Vector3d::Zero();  // four times the centre of each tetrahedron, by volume
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
