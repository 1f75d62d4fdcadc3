#pragma once

#include <array>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "render/tissue/mesh_renderer.h"
#include "render/tissue/seams.h"

namespace hpdm {

/// Fewer triangles over the same vertices, for an organ that is small in the picture.
struct MeshLevel {
  /// Where a vertex that no triangle has any more lies on them, at rest.
  struct Place {
    int vertex;
    std::array<int, 3> corners;    ///< Of a triangle.
    std::array<float, 3> weights;  ///< Of the corners, at least 0, sum 1.
  };

  Triangles triangles;         ///< Over the R drawn vertices (seams.h).
  std::vector<Place> dropped;  ///< Over the R drawn vertices.
  double mean_edge = 0;        ///< m, at rest.
  double error = 0;            ///< m, at rest: the farthest way of a dropped vertex from its place,
                               ///< or the root mean square of how far their texture is drawn off.
};

/// Levels of a mesh, finest first, each of about half of the last one's triangles; the first is the
/// mesh itself. By half-edge collapses in the order of the quadric error (Garland and Heckbert
/// 1997) with a share for the length, which keeps the triangles even. Vertices on a seam of the
/// texture or a border stay, so that the texture is drawn as it is and no gap opens; the levels end
/// where nothing else may go, or below 100 triangles. The same on every run.
///
/// `rest`: V x 3, m; `metres_per_uv`: of the texture's coordinates. O(F log F). Set-up.
std::vector<MeshLevel> MakeLevels(const SeamedMesh& mesh, const Points& rest, double metres_per_uv);

/// m: the farthest way of a dropped vertex from its place when the vertices are at `vertices` (V x
/// 3, m; `copies` as of SeamedMesh), and `level.error` at least. It bounds how far the level's
/// surface is from the mesh's, however that is deformed. O(V); allocates nothing.
double DeformedError(const MeshLevel& level, const std::vector<int>& copies,
                     const PointsF& vertices);

/// Which level is drawn for a size in the picture.
///
/// A level serves while the mean of its edges is at most kMaxEdge pixels, over which interpolated
/// normals shade as those of the mesh, and its error at most kMaxError, so that no silhouette is
/// off by a pixel. It is left for a finer one where it stops serving, and for a coarser one only
/// once that serves with room to spare, so that a picture at the border does not go to and fro.
struct LevelChoice {
  static constexpr double kMaxEdge = 8;     ///< px.
  static constexpr double kMaxError = 0.5;  ///< px.
  static constexpr double kRoom = 0.85;     ///< Of both, for a coarser level than the last.

  /// The level after `last` (of `levels`) at `scale` (px a metre, at most); `error_of(k)` is the
  /// error of level k as the mesh is deformed (m), asked only where its edges and its error at rest
  /// are small enough. Allocates nothing.
  template <typename ErrorOf>
  static int After(int last, const std::vector<MeshLevel>& levels, double scale,
                   const ErrorOf& error_of) {
    const auto serves = [&](int k, double room) {
      if (k == 0) return true;
      const MeshLevel& level = levels[static_cast<std::size_t>(k)];
      return level.mean_edge * scale <= room * kMaxEdge &&
             level.error * scale <= room * kMaxError && error_of(k) * scale <= room * kMaxError;
    };
    int level = last;
    while (!serves(level, 1)) --level;
    if (level < last) return level;
    const int count = static_cast<int>(levels.size());
    while (level + 1 < count && serves(level + 1, kRoom)) ++level;
    return level;
  }
};

}  // namespace hpdm
