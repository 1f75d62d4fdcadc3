#pragma once

#include <optional>

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"

namespace hpdm {

/// A surface by fewer and larger triangles over some of its own vertices, for contacts that begin
/// far from the tip's present place. Constant once built; any thread may read it.
class CoarseSurface {
 public:
  static constexpr double kTriangleArea = 80e-6;  ///< m^2, aimed at: edges of 14 mm.
  static constexpr double kMaxError = 0.001;      ///< m, from the given surface.

  /// Simplifies `mesh` (m) by quadric errors, up to kTriangleArea in the mean or to kMaxError. None
  /// if that leaves more than half of the triangles: the mesh's own then serve as well.
  static std::optional<CoarseSurface> Of(const SurfaceMesh& mesh);

  const Triangles& triangles() const { return triangles_; }
  const SurfaceTopology& topology() const { return topology_; }

  /// Returns the point closest to `p` (m) within `max_distance` (m); triangle -1: none.
  SurfacePoint Closest(const Vector3d& p, double max_distance) const {
    return tree_.Closest(p, max_distance).at;
  }

 private:
  CoarseSurface(const SurfaceMesh& mesh, Triangles triangles);

  Triangles triangles_;
  SurfaceTopology topology_;
  SurfaceTree tree_;
};

}  // namespace hpdm
