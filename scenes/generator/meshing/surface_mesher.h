#pragma once

#include "engine/mesh/surface_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// Parameters of a shape's mesh.
struct SurfaceMesherOptions {
  int triangle_count = 0;        ///< Exact number of triangles; even.
  double level = 0;              ///< Meshes the surface field = level, m (-w: a wall's inside).
  double feature_size = 3.5e-3;  ///< m: the smallest detail of the shape to keep.
};

/// Triangulates a level set:
///
///   1. marching tetrahedra,
///   2. isotropic remeshing on the surface,
///   3. edge collapses to the count, and relaxation,
///   4. a shift of all vertices to a neighbouring level, so that the mesh encloses the shape's own
///      volume. (A coarse mesh with vertices on a convex surface loses volume: 5 % at 274
///      triangles.)
///
/// The result is closed, manifold and oriented outwards, with the same bits on every run. Throws
/// InputError if the count is odd or too small for the shape, or the shape leaves its bounds.
SurfaceMesh MeshImplicitSurface(const ImplicitShape& shape, const SurfaceMesherOptions& options);

/// Returns the volume inside a level set, m^3, from a surface on it by Richardson extrapolation:
/// the triangulation's error falls with the square of its edge length.
double LevelVolume(const ImplicitShape& shape, double level, const SurfaceMesh& mesh);

/// Moves the vertices of a mesh at level -w to the distance w below the surface, so that a wall has
/// one thickness everywhere. The field of joined shapes is smaller than the distance.
void DeepenToDistance(const ImplicitShape& shape, SurfaceMesh* mesh);

/// Returns the surface with the opposite orientation, as for a cavity.
SurfaceMesh TurnedInsideOut(SurfaceMesh mesh);

/// Returns both surfaces as one mesh of separate components.
SurfaceMesh Joined(const SurfaceMesh& first, const SurfaceMesh& second);

}  // namespace hpdm
