#pragma once

#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Counts of the repairs made to a mesh.
struct MeshRepairs {
  int welded_vertices = 0;        ///< Joined to another vertex at the same place.
  int degenerate_triangles = 0;   ///< Dropped: two corners at the same place.
  int duplicate_triangles = 0;    ///< Dropped: same corners as another one, in either orientation.
  int unreferenced_vertices = 0;  ///< Dropped: no triangle uses them.
  int reoriented_triangles = 0;   ///< Flipped (mesh_orientation.h).

  /// The counts that are not zero, as (name, count).
  std::vector<std::pair<std::string, int>> List() const;
};

/// Largest distance of vertices that are welded, as a fraction of the bounding box's diagonal. It
/// is 0.3 um on a liver, above the rounding of 32-bit coordinates and far below any edge.
inline constexpr double kWeldTolerance = 1e-6;
/// The same as a fraction of the 90th percentile of the edge lengths; the smaller bound holds. A
/// part that is far away or far larger thus cannot weld the rest together.
inline constexpr double kWeldEdgeShare = 1e-3;

/// Joins vertices at exactly the same place, which STL files and texture seams repeat. Such
/// vertices are not a defect. O(V log V).
void JoinIdenticalVertices(SurfaceMesh* mesh);

/// Repairs `mesh` in place; coordinates must be finite and indices in range. O((V + F) log F).
///
/// 1. Welds vertices, drops degenerate and duplicate triangles, drops unreferenced vertices;
///    repeats until nothing changes. Needles with distinct corners stay: dropping one would open a
///    crack.
/// 2. Orients the triangles (mesh_orientation.h).
///
/// Corners keep their texture coordinates, so a seam of the texture neither cuts the tissue open
/// nor gets lost. The remaining vertices and triangles keep their order, which does not depend on
/// the texture coordinates.
MeshRepairs RepairMesh(SurfaceMesh* mesh);

}  // namespace hpdm
