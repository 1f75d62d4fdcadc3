#include "engine/mesh/closest_point.h"

#include <algorithm>

namespace hpdm {
namespace {

// Closest parameters (s on ab, t on cd) of two segments.
std::pair<double, double> ClosestOnSegments(const Vector3d& a, const Vector3d& b, const Vector3d& c,
                                            const Vector3d& d) {
  const Vector3d u = b - a, v = d - c, w = a - c;
  const double uu = u.squaredNorm(), vv = v.squaredNorm(), uv = u.dot(v);
  const double uw = u.dot(w), vw = v.dot(w);
  if (uu <= 0) return {0, vv > 0 ? std::clamp(vw / vv, 0.0, 1.0) : 0.0};
  if (vv <= 0) return {std::clamp(-uw / uu, 0.0, 1.0), 0};
  const double determinant = uu * vv - uv * uv;
  double s = determinant > 0 ? std::clamp((uv * vw - uw * vv) / determinant, 0.0, 1.0) : 0.0;
  double t = (uv * s + vw) / vv;
  if (t < 0 || t > 1) {
    t = std::clamp(t, 0.0, 1.0);
    s = std::clamp((uv * t - uw) / uu, 0.0, 1.0);
  }
  return {s, t};
}

}  // namespace

double ClosestOnSegment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d ab = b - a;
  const double length2 = ab.squaredNorm();
  return length2 > 0 ? std::clamp((p - a).dot(ab) / length2, 0.0, 1.0) : 0.0;
}

TrianglePoint ClosestOnTriangle(const Vector3d& p, const Vector3d& a, const Vector3d& b,
                                const Vector3d& c) {
  const auto at = [&](double wa, double wb, double wc) {
    return TrianglePoint{wa * a + wb * b + wc * c, Vector3d(wa, wb, wc)};
  };
  const Vector3d ab = b - a, ac = c - a;
  if (ab.cross(ac).squaredNorm() <= 0) {  // no face: the longest edge
    const double bc2 = (c - b).squaredNorm();
    if (ab.squaredNorm() >= ac.squaredNorm() && ab.squaredNorm() >= bc2) {
      const double t = ClosestOnSegment(p, a, b);
      return at(1 - t, t, 0);
    }
    if (ac.squaredNorm() >= bc2) {
      const double t = ClosestOnSegment(p, a, c);
      return at(1 - t, 0, t);
    }
    const double t = ClosestOnSegment(p, b, c);
    return at(0, 1 - t, t);
  }
  const Vector3d ap = p - a, bp = p - b, cp = p - c;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return at(1, 0, 0);
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return at(0, 1, 0);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    const double t = d1 / (d1 - d3);
    return at(1 - t, t, 0);
  }
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return at(0, 0, 1);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    const double t = d2 / (d2 - d6);
    return at(1 - t, 0, t);
  }
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double t = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return at(0, 1 - t, t);
  }
  const double sum = va + vb + vc;
  return at(va / sum, vb / sum, vc / sum);
}

bool CrossesFromFront(const Vector3d& start, const Vector3d& end, const Vector3d& a,
                      const Vector3d& b, const Vector3d& c, double* along, Vector3d* barycentric) {
  // Moeller and Trumbore 1997, one-sided.
  const Vector3d ab = b - a, ac = c - a, direction = end - start;
  const Vector3d h = direction.cross(ac);
  const double determinant = ab.dot(h);
  if (!(determinant > 0)) return false;
  const Vector3d s = start - a;
  const double u = s.dot(h);
  if (u < 0 || u > determinant) return false;
  const Vector3d q = s.cross(ab);
  const double v = direction.dot(q);
  if (v < 0 || u + v > determinant) return false;
  const double t = ac.dot(q);
  if (t < 0 || t > determinant) return false;
  *along = t / determinant;
  *barycentric = Vector3d(determinant - u - v, u, v) / determinant;
  return true;
}

SegmentTrianglePair ClosestSegmentTriangle(const Vector3d& start, const Vector3d& end,
                                           const Vector3d& a, const Vector3d& b,
                                           const Vector3d& c) {
  SegmentTrianglePair best;
  Vector3d barycentric;
  double along = 0;
  if (CrossesFromFront(start, end, a, b, c, &along, &barycentric)) {
    best = {{start + along * (end - start), barycentric}, along, 0};
    return best;
  }
  // NOLINTNEXTLINE(readability-suspicious-call-argument): the other way
  if (CrossesFromFront(end, start, a, b, c, &along, &barycentric)) {
    best = {{end + along * (start - end), barycentric}, 1 - along, 0};
    return best;
  }
  best.on_triangle = ClosestOnTriangle(start, a, b, c);
  best.along = 0;
  best.squared_distance = (best.on_triangle.point - start).squaredNorm();
  const auto keep_closer = [&](const TrianglePoint& on_triangle, double t) {
    const double distance2 = (on_triangle.point - (start + t * (end - start))).squaredNorm();
    if (distance2 < best.squared_distance) best = {on_triangle, t, distance2};
  };
  keep_closer(ClosestOnTriangle(end, a, b, c), 1);
  const Vector3d corners[3] = {a, b, c};
  for (int e = 0; e < 3; ++e) {
    const auto [s, t] = ClosestOnSegments(start, end, corners[e], corners[(e + 1) % 3]);
    TrianglePoint point;
    point.barycentric[e] = 1 - t;
    point.barycentric[(e + 1) % 3] = t;
    point.point = (1 - t) * corners[e] + t * corners[(e + 1) % 3];
    keep_closer(point, s);
  }
  return best;
}

}  // namespace hpdm
