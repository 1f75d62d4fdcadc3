#pragma once

#include <array>
#include <vector>

#include "engine/mesh/surface_mesh.h"
#include "render/tissue/mesh_renderer.h"
#include "render/tissue/seams.h"

namespace hpdm {

/// Fewer triangles over the same vertices, for an organ that is small in the picture.
struct MeshLevel {
  /// A vertex without triangles, and its nearest point on the level's surface at rest.
  struct Place {
    int vertex;
    std::array<int, 3> corners;    ///< A triangle's vertices.
    std::array<float, 3> weights;  ///< Barycentric: at least 0, sum 1.
  };

  Triangles triangles;         ///< Indices of the R drawn vertices (seams.h).
  std::vector<Place> dropped;  ///< Indices of the R drawn vertices.
  double mean_edge = 0;        ///< Mean edge length at rest, m.
  double error = 0;            ///< m, at rest: the largest distance of a dropped vertex from its
                               ///< place, or the RMS shift of their texture if that is larger.
};

/// Returns the levels of a mesh, finest first. The first is the mesh itself; each of the others has
/// about half of the triangles of the one before. The same on every run.
///
///   method   half-edge collapses in the order of the quadric error (Garland and Heckbert 1997)
///            plus a share of the edge's length, which keeps the triangles even
///   kept     vertices on a border or a seam of the texture, so that no gap opens
///   end      no collapse is allowed, or the next level would have fewer than 100 triangles
///
/// `rest`: V x 3, m; `metres_per_uv`: scale of the texture coordinates. O(F log F). Set-up.
std::vector<MeshLevel> MakeLevels(const SeamedMesh& mesh, const Points& rest, double metres_per_uv);

/// Returns the largest distance (m) of a dropped vertex from its place for deformed `vertices` (V x
/// 3, m; `copies` as in SeamedMesh), at least `level.error`. It bounds the distance between the
/// level's surface and the mesh's. O(V); allocates nothing.
double DeformedError(const MeshLevel& level, const std::vector<int>& copies,
                     const PointsF& vertices);

/// Chooses the drawn level by the size in the picture. A level is fine enough if
///
///   1. its mean edge is at most kMaxEdge pixels, so that interpolated normals shade like the
///      mesh's,
///   2. its error is at most kMaxError, so that no silhouette is off by a pixel.
///
/// A coarser level than the last must meet both with the factor kRoom, so that a picture at the
/// limit does not alternate.
struct LevelChoice {
  static constexpr double kMaxEdge = 8;     ///< px.
  static constexpr double kMaxError = 0.5;  ///< px.
  static constexpr double kRoom = 0.85;     ///< Factor on both limits for a coarser level.

  /// Returns the level after `last` (of `levels`) at `scale` (largest pixels per metre).
  /// `error_of(k)` returns the deformed error of level k (m); it is called only if the level's
  /// edges and error at rest are small enough. Allocates nothing.
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
