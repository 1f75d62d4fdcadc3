#include "engine/tissue/layer_tensions.h"

#include <algorithm>
#include <cmath>

#include "engine/tissue/support.h"

namespace hpdm {

LayerTensions::LayerTensions(const std::vector<LayerOptions>& layers, const SurfaceMesh& outer,
                             const Box& bounds)
    : layers_(layers) {
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    for (Eigen::Index t = 0; t < outer.triangles.rows(); ++t) {
      Triangle triangle{.layer = l, .corners = {}, .edges = {}, .plane = {}, .inverse = {}};
      std::array<Vector3d, 3> at;
      for (std::size_t k = 0; k < 3; ++k) {
        triangle.corners[k] = outer.triangles(t, static_cast<Eigen::Index>(k));
        at[k] = outer.vertices.row(triangle.corners[k]);
      }
      const Vector3d centroid = (at[0] + at[1] + at[2]) / 3;
      if (layers_[l].region && !InRegion(*layers_[l].region, bounds, centroid)) continue;
      triangle.edges << at[1] - at[0], at[2] - at[0];
      const Vector3d normal = triangle.edges.col(0).cross(triangle.edges.col(1));
      if (!(normal.norm() > 0)) continue;
      triangle.plane.col(0) = triangle.edges.col(0).normalized();
      triangle.plane.col(1) = normal.normalized().cross(triangle.plane.col(0));
      triangle.inverse = (triangle.plane.transpose() * triangle.edges).inverse();
      triangles_.push_back(triangle);
    }
  }
}

void LayerTensions::FindLargest(const Points& vertices, const Matrix3d& R_WF,
                                std::span<double> largest) const {
  std::ranges::fill(largest, 0.0);
  for (const Triangle& triangle : triangles_) {
    const auto& [first, second, third] = triangle.corners;
    Eigen::Matrix<double, 3, 2> moved;
    moved << (vertices.row(second) - vertices.row(first)).transpose(),
        (vertices.row(third) - vertices.row(first)).transpose();
    // Element (a, b): the displacement along a, by the length along b.
    const Eigen::Matrix2d gradient =
        triangle.plane.transpose() * (R_WF.transpose() * moved - triangle.edges) * triangle.inverse;
    const LayerOptions& layer = layers_[triangle.layer];
    const double sum = gradient(0, 0) + gradient(1, 1), apart = gradient(0, 0) - gradient(1, 1);
    const double sheared = gradient(0, 1) + gradient(1, 0);
    const double tension =
        layer.stiffness / 2 *
        (sum / (1 - layer.poisson) + std::hypot(apart, sheared) / (1 + layer.poisson));
    largest[triangle.layer] = std::max(largest[triangle.layer], tension);
  }
}

}  // namespace hpdm
