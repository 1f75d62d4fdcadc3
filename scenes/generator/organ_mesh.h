#pragma once

#include "engine/mesh/surface_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Numbers of an organ's mesh.
struct OrganMeshOptions {
  int outer_triangles = 0;   ///< Even.
  int cavity_triangles = 0;  ///< Even; 0 for a solid.
  double wall = 0;           ///< m: thickness of a hollow organ's wall.
};

/// Meshes an organ, with the texture coordinates of an atlas. A hollow organ is its outer surface,
/// then its cavity's, facing the cavity. The same bits on every run and x86-64 machine. Throws
/// InputError as MeshImplicitSurface does.
SurfaceMesh MeshOrgan(const ImplicitShape& shape, const OrganMeshOptions& options);

}  // namespace hpdm
