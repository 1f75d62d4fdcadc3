#pragma once

#include <optional>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// What a surface is, counted. Lengths in m.
struct MeshFacts {
  int vertices = 0;
  int triangles = 0;
  int boundary_edges = 0;        ///< Edges of one triangle only; 0 when closed.
  int nonmanifold_edges = 0;     ///< Edges of three or more triangles.
  int inconsistent_edges = 0;    ///< Edges whose two triangles run along them the same way.
  int components = 0;            ///< Sets of triangles connected through vertices.
  int degenerate_triangles = 0;  ///< Height below 1e-6 of the longest side, or a corner twice.
  double volume_m3 = 0;          ///< Enclosed; for an open surface an estimate.
  double area_m2 = 0;
  Vector3d box_min = Vector3d::Zero();  ///< Axis-aligned bounding box.
  Vector3d box_max = Vector3d::Zero();
  double min_edge = 0;
  double mean_edge = 0;
  int euler_characteristic = 0;  ///< V - E + F, of the vertices in use.
  std::optional<int> genus;      ///< Handles of all components together; closed manifolds only.

  bool Closed() const { return triangles > 0 && boundary_edges == 0 && nonmanifold_edges == 0; }
};

/// The facts of the same surface measured in another unit.
MeshFacts Scaled(const MeshFacts& facts, double metres_per_unit);

/// Counts the facts of a mesh whose indices are in range. O(F log F).
MeshFacts ComputeMeshFacts(const SurfaceMesh& mesh);

}  // namespace hpdm
