#pragma once

#include <array>
#include <span>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// The tensions of an organ's layers, constant on each triangle of the outer surface: linear in the
/// displacements of its corners, as the layers' energy is (fillings_and_layers.h). Constant once built;
/// any thread may read it.
class LayerTensions {
 public:
  LayerTensions() = default;
  /// Takes the triangles of `outer` whose centroid lies in a layer's region. `bounds`: of the organ.
  LayerTensions(const std::vector<LayerOptions>& layers, const SurfaceMesh& outer,
                const Box& bounds);

  std::size_t layers() const { return layers_.size(); }
  /// Sets the largest principal tension of each layer, N/m; 0 where all of it is slack. `vertices`:
  /// V x 3, m; `R_WF`: rotation of a free organ's frame. O(triangles), no allocation.
  void FindLargest(const Points& vertices, const Matrix3d& R_WF, std::span<double> largest) const;

 private:
  struct Triangle {
    std::size_t layer = 0;
    std::array<int, 3> corners{};
    Eigen::Matrix<double, 3, 2> edges;  // at rest, m: to the corners 1 and 2 from 0
    Eigen::Matrix<double, 3, 2> plane;  // unit vectors
    Eigen::Matrix2d inverse;            // 1/m: of the edges in the plane
  };
  std::vector<LayerOptions> layers_;
  std::vector<Triangle> triangles_;
};

}  // namespace hpdm
