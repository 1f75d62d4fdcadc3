#pragma once

#include <optional>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Counts and measures of a surface. Lengths in m.
struct MeshFacts {
  int vertices = 0;
  int triangles = 0;
  int boundary_edges = 0;        ///< Edges of only one triangle; 0 for a closed surface.
  int nonmanifold_edges = 0;     ///< Edges of three or more triangles.
  int inconsistent_edges = 0;    ///< Edges along which both triangles run the same way.
  int components = 0;            ///< Sets of triangles connected through vertices.
  int degenerate_triangles = 0;  ///< Height below 1e-6 of the longest side, or equal corners.
  double volume_m3 = 0;          ///< Enclosed volume; an estimate for an open surface.
  double area_m2 = 0;
  Vector3d box_min = Vector3d::Zero();  ///< Axis-aligned bounding box.
  Vector3d box_max = Vector3d::Zero();
  double min_edge = 0;
  double mean_edge = 0;
  int euler_characteristic = 0;  ///< V - E + F, where V counts only the vertices in use.
  std::optional<int> genus;      ///< Sum of the components' handles; closed manifolds only.

  bool Closed() const { return triangles > 0 && boundary_edges == 0 && nonmanifold_edges == 0; }
};

/// Returns the facts of the same surface, measured in another unit.
MeshFacts Scaled(const MeshFacts& facts, double metres_per_unit);

/// Computes the facts of a mesh whose indices are in range. O(F log F).
MeshFacts ComputeMeshFacts(const SurfaceMesh& mesh);

}  // namespace hpdm
