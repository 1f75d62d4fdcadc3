#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// A point of a triangle abc.
struct TrianglePoint {
  Vector3d point = Vector3d::Zero();
  Vector3d barycentric = Vector3d::Zero();  ///< Weights of a, b, c; sum to one.
};

/// Returns the point of triangle abc closest to `p`, by the Voronoi regions of its corners, edges
/// and face (Ericson, Real-Time Collision Detection, 5.1.5). For a degenerate triangle it is a
/// point of the longest edge. Any thread, wait-free, no allocation.
TrianglePoint ClosestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                                const Vector3d& c);

/// Returns the parameter (0..1) of the point of segment ab closest to `p`; 0 for a segment without
/// length.
double ClosestOnSegment(const Vector3d& p, const Vector3d& a, const Vector3d& b);
/// Returns that point itself.
inline Vector3d ClosestPointOnSegment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  return a + ClosestOnSegment(p, a, b) * (b - a);
}

/// The pair of closest points of the segment from `start` to `end` and the triangle abc.
struct SegmentTrianglePair {
  TrianglePoint on_triangle;
  double along = 0;             ///< Parameter (0..1) of the point on the segment.
  double squared_distance = 0;  ///< 0 when they cross.
};
SegmentTrianglePair ClosestSegmentTriangle(const Vector3d& start, const Vector3d& end,
                                           const Vector3d& a, const Vector3d& b, const Vector3d& c);

/// Returns true if the segment from `start` to `end` enters triangle abc from its front, the side
/// to which its counter-clockwise normal points. Sets `along` (0..1 on the segment) and
/// `barycentric`.
bool CrossesFromFront(const Vector3d& start, const Vector3d& end, const Vector3d& a,
                      const Vector3d& b, const Vector3d& c, double* along, Vector3d* barycentric);

}  // namespace hpdm
