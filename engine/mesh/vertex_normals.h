#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// VertexNormals (surface_mesh.h) in the precision of `vertices` (V x 3).
template <typename Vertices>
void SetVertexNormals(const Vertices& vertices, const Triangles& triangles, Vertices* normals) {
  using Vector = Eigen::Matrix<typename Vertices::Scalar, 1, 3>;
  if (normals->rows() != vertices.rows()) normals->resize(vertices.rows(), 3);
  normals->setZero();
  for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
    const Vector a = vertices.row(triangles(t, 0));
    const Vector ab = vertices.row(triangles(t, 1)) - a, ac = vertices.row(triangles(t, 2)) - a;
    const Vector twice_area_normal = ab.cross(ac);
    for (int k = 0; k < 3; ++k) normals->row(triangles(t, k)) += twice_area_normal;
  }
  for (Eigen::Index v = 0; v < normals->rows(); ++v) {
    const auto length = normals->row(v).norm();
    if (length > 0) normals->row(v) /= length;
  }
}

}  // namespace hpdm
