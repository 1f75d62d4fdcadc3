#pragma once

#include <memory>

#include "engine/base/types.h"

namespace hpdm {

/// A point of a surface: a triangle and weights of its corners.
struct SurfacePoint {
  int triangle = -1;
  Vector3d barycentric = Vector3d::Zero();

  Vector3d Position(const Points& vertices, const Triangles& triangles) const {
    return (barycentric.transpose() * vertices(triangles.row(triangle), Eigen::all)).transpose();
  }
};

/// What a query found; `at.triangle` is -1 when it found nothing.
struct SurfaceHit {
  SurfacePoint at;
  double distance = 0;  ///< m.
  double along = 0;     ///< Segments only: parameter 0..1 of the closest or crossing point.
};

/// Tree of axis-aligned bounding boxes over an organ's triangles, split at the middle of the
/// longest axis, kept while the vertices move (paper 3.2.3). FCL builds and holds the tree; refit
/// and queries walk its nodes, because FCL 0.7 copies the whole tree in a collision with a shape
/// and has no distance from an AABB tree to a capsule. Queries are exact, cost O(log F + triangles
/// near) in the usual case and no more than a look at the outermost box where that is out of reach;
/// they allocate nothing, and may run in several threads between refits.
class SurfaceTree {
 public:
  /// `vertices` (V x 3, m), `triangles` (F x 3), F >= 1.
  SurfaceTree(const Points& vertices, const Triangles& triangles);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;

  /// Takes new vertex positions (V x 3) and refits the boxes from the leaves up, O(F). No
  /// allocation.
  void Refit(const Points& vertices);

  /// Closest point to `p` (a sphere's centre) within `max_distance` (m).
  SurfaceHit Closest(const Vector3d& p, double max_distance) const;

  /// Closest point to the segment (a capsule's axis) within `max_distance` (m).
  SurfaceHit ClosestToSegment(const Vector3d& start, const Vector3d& end,
                              double max_distance) const;

  /// First place where a point that moves from `start` to `end` enters the surface from outside.
  SurfaceHit FirstEntry(const Vector3d& start, const Vector3d& end) const;

 private:
  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace hpdm
