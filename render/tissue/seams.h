#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A mesh as the graphics card draws it: R vertices, one for every pair of a mesh vertex and a
/// texture coordinate. The first V are the mesh's vertices in order. Copies follow for each further
/// texture coordinate of a vertex on a seam.
struct SeamedMesh {
  std::vector<int> copies;  ///< R - V: the mesh vertex of each copy.
  Triangles triangles;      ///< F x 3, indices of the R vertices.
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>
      texture_coordinates;  ///< R x 2; 0 without.
};

/// Cuts the mesh open along the seams of its texture, if it has one. Texture coordinates must have
/// 0 or 3 F rows; anything else is a bug.
SeamedMesh CutSeams(const SurfaceMesh& mesh);

}  // namespace hpdm
