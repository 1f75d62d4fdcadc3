#pragma once

#include "engine/mesh/surface_mesh.h"
#include "scenes/generator/shapes/implicit_shapes.h"

namespace hpdm {

/// What to make of a shape.
struct SurfaceMesherOptions {
  int triangle_count = 0;        ///< Exactly so many; even.
  double level = 0;              ///< Mesh the surface field = level, m (-w: the inside of a wall).
  double feature_size = 3.5e-3;  ///< m: smallest detail of the shape that must not be lost.
};

/// Triangulates a level set: marching tetrahedra, isotropic remeshing on the surface, edge
/// collapses to the count, relaxation, and last a shift of all vertices to a neighbouring level
/// such that the mesh encloses the volume of the shape itself (with its vertices on the surface a
/// coarse mesh of a convex shape loses volume: 5 % at 274 triangles). The result is closed,
/// manifold, oriented outwards; the same bits on every run. Throws InputError when the count is
/// odd, too small for the shape, or the shape leaves its bounds.
SurfaceMesh MeshImplicitSurface(const ImplicitShape& shape, const SurfaceMesherOptions& options);

/// Volume inside a level set, m^3, from a surface on it by Richardson extrapolation: the
/// triangulation's error falls with the square of its edge length.
double LevelVolume(const ImplicitShape& shape, double level, const SurfaceMesh& mesh);

/// Moves the vertices of a mesh of a negative level to the depth below the surface that the level
/// names, measured as distance: joined shapes' fields fall short of it. What a wall needs to be
/// equally thick everywhere.
void DeepenToDistance(const ImplicitShape& shape, SurfaceMesh* mesh);

/// The same surface facing the other way (a cavity's).
SurfaceMesh TurnedInsideOut(SurfaceMesh mesh);

/// Both surfaces as one mesh of separate components.
SurfaceMesh Joined(const SurfaceMesh& first, const SurfaceMesh& second);

}  // namespace hpdm
