#pragma once

#include <memory>

#include "engine/base/types.h"

namespace hpdm {

/// A point of a surface: a triangle and the barycentric weights of its corners.
struct SurfacePoint {
  int triangle = -1;
  Vector3d barycentric = Vector3d::Zero();

  Vector3d Position(const Points& vertices, const Triangles& triangles) const {
    const auto a = vertices.row(triangles(triangle, 0)), b = vertices.row(triangles(triangle, 1)),
               c = vertices.row(triangles(triangle, 2));
    return (barycentric[0] * a + (barycentric[1] * b + barycentric[2] * c)).transpose();
  }
};

/// The result of a query; `at.triangle` is -1 if nothing was found.
struct SurfaceHit {
  SurfacePoint at;
  double distance = 0;  ///< m.
  double along = 0;     ///< Segments only: parameter 0..1 of the closest or crossing point.
};

/// Tree of axis-aligned bounding boxes over an organ's triangles, split at the middle of the
/// longest axis and kept while the vertices move (paper 3.2.3).
///
/// 1. FCL builds the tree. Copies share its nodes and have boxes of their own. Refit and queries
///    walk the nodes themselves, because FCL 0.7 copies the whole tree to collide it with a shape
///    and has no AABB-tree-to-capsule distance.
/// 2. Queries are exact. They cost O(log F + triangles near) in the usual case, and one box test if
///    the outermost box is out of reach.
/// 3. Queries allocate nothing and may run in several threads between refits.
class SurfaceTree {
 public:
  /// `vertices` (V x 3, m), `triangles` (F x 3), F >= 1.
  SurfaceTree(const Points& vertices, const Triangles& triangles);
  ~SurfaceTree();
  SurfaceTree(SurfaceTree&&) noexcept;
  SurfaceTree(const SurfaceTree& other);
  /// Takes over the other's shape. Both are of the same triangles: no allocation.
  SurfaceTree& operator=(const SurfaceTree& other);

  /// Takes new vertex positions (V x 3, m) and refits the boxes from the leaves up. O(F), no
  /// allocation.
  void Refit(const Points& vertices);

  /// Finds the closest point to `p` (a sphere's centre) within `max_distance` (m).
  SurfaceHit Closest(const Vector3d& p, double max_distance) const;

  /// Finds the closest point to the segment (a capsule's axis) within `max_distance` (m).
  SurfaceHit ClosestToSegment(const Vector3d& start, const Vector3d& end,
                              double max_distance) const;

  /// Finds where a capsule first comes as near as `radius` (m) to the surface while the ends of its
  /// axis move straight from `start` and `end` to `start_to` and `end_to`. No motion passes through:
  /// each advance is at most the present distance (conservative advancement: Mirtich 1996). `share`
  /// gets the part of the motion before it; `distance` and `along` are those of that time. A grazing
  /// motion of more than 64 advances counts as a touch.
  SurfaceHit FirstTouch(const Vector3d& start, const Vector3d& end, const Vector3d& start_to,
                        const Vector3d& end_to, double radius, double* share) const;

  /// Finds the first place where a point that moves from `start` to `end` enters the surface from
  /// outside.
  SurfaceHit FirstEntry(const Vector3d& start, const Vector3d& end) const;

  /// Visits the triangles whose boxes come within `reach` (m) of `p`, near ones first. visit(int
  /// triangle) returns the reach from then on.
  template <typename Visitor>
  void VisitNear(const Vector3d& p, double reach, Visitor visit) const {
    Visit(
        p, reach, [](void* v, int triangle) { return (*static_cast<Visitor*>(v))(triangle); },
        &visit);
  }

  /// Visits the triangles of this tree whose box comes within `reach` (m) along every axis of the
  /// box of some triangle of `other`, moved by `offset` (m). Each one once, in the tree's order.
  /// The two trees are descended together: one box test if they are apart.
  template <typename Visitor>
  void VisitNear(const SurfaceTree& other, const Vector3d& offset, double reach,
                 Visitor visit) const {
    Visit(
        other, offset, reach, [](void* v, int triangle) { (*static_cast<Visitor*>(v))(triangle); },
        &visit);
  }

 private:
  void Visit(const Vector3d& p, double reach, double (*visit)(void*, int), void* visitor) const;
  void Visit(const SurfaceTree& other, const Vector3d& offset, double reach,
             void (*visit)(void*, int), void* visitor) const;

  struct Tree;
  std::unique_ptr<Tree> tree_;
};

}  // namespace hpdm
