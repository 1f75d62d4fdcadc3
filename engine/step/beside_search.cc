#include "engine/step/beside_search.h"

#include <algorithm>

#include "engine/mesh/closest_point.h"

namespace hpdm {
namespace {

constexpr double kAhead = 1e-12;  // m^2, of rounding
constexpr double kOutside =
    0.2;  // least cosine between the direction to the tip and the triangle's normal

// True if no triangle around the point is nearer to p, which lies at `offset` from it: a point of a
// convex set is the closest one if no corner lies ahead of it towards p.
bool IsLeast(const OrganModel& model, const Points& vertices, const SurfacePoint& at,
             const Vector3d& offset) {
  const Triangles& triangles = model.rest().triangles;
  const Vector3d q = at.Position(vertices, triangles);
  int corner = 0;
  at.barycentric.maxCoeff(&corner);
  const auto has = [&](int triangle, int vertex) {
    return (triangles.row(triangle).array() == vertex).any();
  };
  for (const int t : model.topology().TrianglesAround(triangles(at.triangle, corner))) {
    bool around = true;
    for (int k = 0; k < 3; ++k) {
      around = around && (at.barycentric[k] == 0 || has(t, triangles(at.triangle, k)));
    }
    for (int k = 0; around && k < 3; ++k) {
      if (offset.dot(vertices.row(triangles(t, k)).transpose() - q) > kAhead) return false;
    }
  }
  return true;
}

}  // namespace

SurfaceHit FindBeside(const OrganModel& model, const OrganState& state, const Vector3d& p,
                      double reach, std::span<const Vector3d> normals) {
  const Triangles& triangles = model.rest().triangles;
  SurfaceHit best;
  best.distance = reach;
  state.tree.VisitNear(p, reach, [&](int t) {
    const Vector3d a = state.vertices.row(triangles(t, 0)), b = state.vertices.row(triangles(t, 1)),
                   c = state.vertices.row(triangles(t, 2));
    const Vector3d twice_area = (b - a).cross(c - a);
    if (!((p - a).dot(twice_area) > 0)) return best.distance;
    const TrianglePoint closest = ClosestOnTriangle(p, a, b, c);
    const Vector3d offset = p - closest.point;
    const double distance = offset.norm();
    if (!(distance > 0) || distance >= best.distance) return best.distance;
    if (offset.dot(twice_area) < kOutside * distance * twice_area.norm()) return best.distance;
    if (!IsApart(offset / distance, normals)) return best.distance;
    const SurfacePoint at{t, closest.barycentric};
    if (!IsLeast(model, state.vertices, at, offset)) return best.distance;
    best.at = at;
    best.distance = distance;
    return best.distance;
  });
  return best;
}

}  // namespace hpdm
