#pragma once

#include <string>
#include <utility>
#include <vector>

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// What was mended in a mesh, counted.
struct MeshRepairs {
  int welded_vertices = 0;       ///< Joined to another one at the same place.
  int degenerate_triangles = 0;  ///< Dropped: two corners at the same place.
  int duplicate_triangles = 0;   ///< Dropped: the same corners as another one, whichever way round.
  int unreferenced_vertices = 0;  ///< Dropped: no triangle names them.
  int reoriented_triangles = 0;   ///< Turned round (mesh_orientation.h).

  /// Those that are not zero, as (name, count).
  std::vector<std::pair<std::string, int>> List() const;
};

/// Vertices closer than this fraction of the bounding box's diagonal are one vertex: 0.3 um on a
/// liver, above the rounding of 32-bit coordinates and far below any edge.
inline constexpr double kWeldTolerance = 1e-6;
/// And closer than this fraction of the edge that nine tenths of the edges do not exceed, so that
/// a part that lies far away or is far larger does not melt the rest.
inline constexpr double kWeldEdgeShare = 1e-3;

/// Joins vertices at exactly the same place, which STL and texture seams repeat: no repair but a
/// way of writing. O(V log V).
void JoinIdenticalVertices(SurfaceMesh* mesh);

/// Mends `mesh` in place, in this order: weld, drop degenerate and duplicate triangles, drop
/// unreferenced vertices (these until nothing is left to mend), orient. Needles whose corners
/// differ stay, since dropping one would open a crack. Corners keep their texture coordinates, so
/// that a texture's seams neither cut the tissue open nor get lost. Coordinates must be finite and
/// indices in range. The order of what remains is the mesh's own, whatever its texture coordinates;
/// O((V + F) log F).
MeshRepairs RepairMesh(SurfaceMesh* mesh);

}  // namespace hpdm
