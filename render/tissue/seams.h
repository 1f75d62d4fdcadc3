#pragma once

#include <Eigen/Core>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// A mesh as the graphics card draws it: one vertex for every pair of a mesh vertex and a texture
/// coordinate that meet in a triangle's corner. The first V are the mesh's own vertices in their
/// order; those on a seam of the texture follow once for each further coordinate.
struct SeamedMesh {
  std::vector<int> copies;  ///< R - V: the mesh vertex that each further one repeats.
  Triangles triangles;      ///< F x 3, over the R vertices.
  Eigen::Matrix<float, Eigen::Dynamic, 2, Eigen::RowMajor>
      texture_coordinates;  ///< R x 2; 0 without.
};

/// Cuts the mesh open along the seams of its texture; a mesh without coordinates has none. Rows of
/// coordinates other than 0 or 3 F are a bug.
SeamedMesh CutSeams(const SurfaceMesh& mesh);

}  // namespace hpdm
