#include "haptics/patch_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/closest_point.h"

namespace hpdm {
namespace {

constexpr double kBorderTolerance = 1e-6;  // m, sideways of the border
constexpr double kInside = -1e-9;          // smallest weight of a point inside a triangle
constexpr double kSameFoot = 1e-6;         // m, between the last foot and the patch
// Offset surface's area over the released one's: 0 at the centre of curvature, where the foot runs
// away. A foot that is held has no reason to go so far: 0.1 is two thirds of the way down to the
// centre of a sphere, where the foot moves three times as fast as the tip.
constexpr double kLeastArea = 1e-6;
constexpr double kLeastAreaHeld = 0.1;
constexpr double kLeastTurnCosine = 0.998;  // 3.6 degrees a search: more leads to another side
constexpr int kMaxNewtonSteps = 12;
constexpr int kMaxMarch = 16;
constexpr double kLeastCosine = 0.2;  // between interpolated and face normal
constexpr double kMostStretch = 3;    // of a foot's distance over the closest one
constexpr double kSettledWeight = 1e-10;
constexpr double kSettled = 1e-12;     // m
constexpr double kLeastAspect = 1e-9;  // twice the area over the longest edge squared

bool InRange(const std::array<std::uint8_t, 3>& corners, int point_count) {
  return corners[0] < point_count && corners[1] < point_count && corners[2] < point_count;
}

}  // namespace

void PatchSurface::Build(const ToolPatch& patch) noexcept {
  triangle_count_ = 0;
  const int point_count = std::clamp(patch.point_count, 0, kMaxPoints);
  const int given = std::clamp(patch.triangle_count, 0, kMaxTriangles);
  for (int i = 0; i < point_count; ++i) {
    points_W_[i] = patch.points[i].p_original_W;
    const Vector3d& n = patch.points[i].normal_W;
    const double length = n.norm();
    normals_W_[i] = length > 0.5 && length < 2 ? Vector3d(n / length) : Vector3d::Zero();
  }
  for (auto& row : left_of_) row.fill(kNone);
  for (int t = 0; t < given; ++t) {
    const Corners& corners = patch.triangles[t];
    if (!InRange(corners, point_count)) continue;
    const Vector3d &a = points_W_[corners[0]], &b = points_W_[corners[1]],
                   &c = points_W_[corners[2]];
    const Vector3d twice_area = (b - a).cross(c - a);
    const double longest_squared =
        std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    // Written so that a coordinate that is not finite leaves the triangle out.
    const bool usable = twice_area.norm() > kLeastAspect * longest_squared && longest_squared > 0 &&
                        std::isfinite(longest_squared);
    const int slot = triangle_count_;
    for (int i = 0; i < 3; ++i) {
      left_of_[corners[i]][corners[(i + 1) % 3]] =
          usable ? static_cast<std::uint8_t>(slot) : kLeftOut;
    }
    if (!usable) continue;
    const Vector3d centre = (a + b + c) / 3;
    triangles_[slot] = corners;
    face_normals_W_[slot] = twice_area.normalized();
    centre_x_[slot] = centre.x();
    centre_y_[slot] = centre.y();
    centre_z_[slot] = centre.z();
    radius_[slot] = std::sqrt(std::max(
        {(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()}));
    ++triangle_count_;
  }
}

void PatchSurface::StartAt(const Corners& corners, const Vector3d& weights) noexcept {
  has_last_ = true;
  p_last_W_ = Interpolated(points_W_, corners, weights);
  normal_last_W_ = Interpolated(normals_W_, corners, weights).normalized();
}

bool PatchSurface::FindFoot(const Vector3d& c_W, double reach, SurfaceFoot* foot) noexcept {
  const bool found =
      (has_last_ && FindFootFromLast(c_W, reach, foot)) || FindFootFromClosest(c_W, reach, foot);
  has_last_ = found;
  if (found) {
    p_last_W_ = Interpolated(points_W_, foot->corners, foot->weights);
    normal_last_W_ = foot->normal_W;
  }
  return found;
}

bool PatchSurface::FindFootFromLast(const Vector3d& c_W, double reach, SurfaceFoot* foot) const {
  Closest start = FindClosest(p_last_W_);
  if (start.triangle < 0 || start.distance > kSameFoot) return false;  // not in this patch
  start.offset_W = c_W - p_last_W_;
  start.distance = start.offset_W.norm();
  if (FollowNormals(c_W, start, kLeastAreaHeld, foot) &&
      foot->normal_W.dot(normal_last_W_) >= kLeastTurnCosine) {
    return foot->gap <= reach;
  }

  // Near the centre of curvature or beyond it: the last foot holds.
  const double gap = start.offset_W.dot(normal_last_W_);
  const double sideways = (start.offset_W - gap * normal_last_W_).norm();
  if (gap > reach || sideways > std::abs(gap)) return false;
  foot->corners = triangles_[start.triangle];
  foot->weights = start.weights;
  foot->normal_W = normal_last_W_;
  foot->gap = gap;
  return true;
}

bool PatchSurface::FindFootFromClosest(const Vector3d& c_W, double reach, SurfaceFoot* foot) const {
  const Closest closest = FindClosest(c_W);
  if (closest.triangle < 0) return false;

  const Corners& corners = triangles_[closest.triangle];
  const Vector3d& face_normal = face_normals_W_[closest.triangle];
  Vector3d normal = Interpolated(normals_W_, corners, closest.weights);
  // Opposed or missing vertex normals leave the face's own.
  normal = normal.norm() > kLeastCosine ? normal.normalized() : face_normal;
  const bool inside_face = closest.weights.minCoeff() > 0;
  const bool outside = closest.offset_W.dot(inside_face ? face_normal : normal) >= 0;
  if (outside && closest.distance > reach) return false;

  if (FollowNormals(c_W, closest, kLeastArea, foot)) return foot->gap <= reach;

  if (IsOnBorder(closest)) {
    const Vector3d sideways = closest.offset_W - closest.offset_W.dot(face_normal) * face_normal;
    if (sideways.norm() > kBorderTolerance) return false;
  }
  foot->corners = corners;
  foot->weights = closest.weights;
  foot->gap = outside ? closest.distance : -closest.distance;
  foot->normal_W = closest.distance > kSettled ? Vector3d(closest.offset_W / foot->gap) : normal;
  return true;
}

PatchSurface::Closest PatchSurface::FindClosest(const Vector3d& c_W) const {
  std::array<double, kMaxTriangles> to_centre;
  for (int t = 0; t < triangle_count_; ++t) {
    const double x = centre_x_[t] - c_W.x(), y = centre_y_[t] - c_W.y(), z = centre_z_[t] - c_W.z();
    to_centre[t] = std::sqrt(x * x + y * y + z * z);
  }
  Closest best;
  best.distance = std::numeric_limits<double>::infinity();
  const auto try_triangle = [&](int t) {
    const Corners& corners = triangles_[t];
    const Vector3d weights =
        ClosestOnTriangle(c_W, points_W_[corners[0]], points_W_[corners[1]], points_W_[corners[2]])
            .barycentric;
    const Vector3d offset = c_W - Interpolated(points_W_, corners, weights);
    const double distance = offset.norm();
    if (distance < best.distance) best = {t, weights, offset, distance};
  };
  // The triangle with the nearest centre gives a bound that leaves most others out.
  int nearest = -1;
  for (int t = 0; t < triangle_count_; ++t) {
    if (nearest < 0 || to_centre[t] < to_centre[nearest]) nearest = t;
  }
  if (nearest >= 0) try_triangle(nearest);
  for (int t = 0; t < triangle_count_; ++t) {
    if (t != nearest && to_centre[t] - radius_[t] < best.distance) try_triangle(t);
  }
  return best;
}

bool PatchSurface::FollowNormals(const Vector3d& c_W, const Closest& start, double least_area,
                                 SurfaceFoot* foot) const {
  int triangle = start.triangle;
  Vector3d weights = start.weights;
  double t = start.offset_W.dot(Interpolated(normals_W_, triangles_[triangle], weights));
  for (int march = 0; march < kMaxMarch; ++march) {
    const Corners& corners = triangles_[triangle];
    const Vector3d &p0 = points_W_[corners[0]], &n0 = normals_W_[corners[0]];
    const Vector3d e1 = points_W_[corners[1]] - p0, e2 = points_W_[corners[2]] - p0;
    const Vector3d m1 = normals_W_[corners[1]] - n0, m2 = normals_W_[corners[2]] - n0;

    // Newton's method for p(w) + t n(w) = c in the weights w1, w2 and t.
    double w1 = weights[1], w2 = weights[2];
    Vector3d n;
    bool settled = false;
    for (int step = 0; step < kMaxNewtonSteps && !settled; ++step) {
      n = n0 + w1 * m1 + w2 * m2;
      const Vector3d missing = c_W - (p0 + w1 * e1 + w2 * e2) - t * n;
      const Vector3d c1 = e1 + t * m1, c2 = e2 + t * m2;
      const Vector3d c1_c2 = c1.cross(c2);
      const double determinant = c1_c2.dot(n);
      // Positive: the offset surface has not folded over, c lies before the centre of curvature.
      if (!(determinant > least_area * e1.cross(e2).dot(n))) return false;
      const double d1 = missing.dot(c2.cross(n)) / determinant;
      const double d2 = missing.dot(n.cross(c1)) / determinant;
      const double dt = missing.dot(c1_c2) / determinant;
      w1 += d1;
      w2 += d2;
      t += dt;
      settled = std::abs(d1) + std::abs(d2) < kSettledWeight && std::abs(dt) < kSettled;
    }
    if (!settled) return false;
    weights = Vector3d(1 - w1 - w2, w1, w2);

    int lowest = 0;
    const double least = weights.minCoeff(&lowest);
    if (least >= kInside) {
      n = n0 + w1 * m1 + w2 * m2;
      const double length = n.norm();
      if (n.dot(face_normals_W_[triangle]) < kLeastCosine * length) return false;
      if (std::abs(t) * length > kMostStretch * start.distance + kSettled) return false;
      foot->corners = corners;
      foot->weights = weights;
      foot->normal_W = n / length;
      foot->gap = t * length;
      return true;
    }
    // Across the edge opposite the lowest weight, from where the foot left the triangle.
    const std::uint8_t from = corners[(lowest + 1) % 3], to = corners[(lowest + 2) % 3];
    const std::uint8_t next = left_of_[to][from];
    if (next >= triangle_count_) return false;
    const double along = std::clamp(
        weights[(lowest + 2) % 3] / (weights[(lowest + 1) % 3] + weights[(lowest + 2) % 3]), 0.0,
        1.0);
    triangle = next;
    for (int i = 0; i < 3; ++i) {
      const std::uint8_t corner = triangles_[next][i];
      weights[i] = corner == from ? 1 - along : corner == to ? along : 0;
    }
  }
  return false;
}

bool PatchSurface::IsOnBorder(const Closest& closest) const {
  const Corners& corners = triangles_[closest.triangle];
  int zeros = 0, zero = 0, one = 0;
  for (int i = 0; i < 3; ++i) {
    if (closest.weights[i] == 0) {
      ++zeros;
      zero = i;
    } else {
      one = i;
    }
  }
  if (zeros == 0) return false;
  if (zeros == 1) {
    return left_of_[corners[(zero + 2) % 3]][corners[(zero + 1) % 3]] == kNone;
  }
  // A vertex is on the border when one of its edges lacks its other side.
  const std::uint8_t vertex = corners[one];
  for (int other = 0; other < kMaxPoints; ++other) {
    if ((left_of_[vertex][other] == kNone) != (left_of_[other][vertex] == kNone)) return true;
  }
  return false;
}

}  // namespace hpdm
