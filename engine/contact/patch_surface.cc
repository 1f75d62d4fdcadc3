#include "engine/contact/patch_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/contact_patch.h"
#include "engine/mesh/closest_point.h"
#include "engine/mesh/curved_surface.h"

namespace hpdm {
namespace {

constexpr double kBorderTolerance = 1e-6;  // m, sideways of the border
constexpr double kInside = -1e-9;          // smallest weight of a point inside a triangle
constexpr double kSameFoot = 0.005;        // m, from a contact to the surface of its next patch
// Offset surface's area over the released one's: 0 at the centre of curvature, where the foot
// diverges.
constexpr double kMinArea = 1e-6;
constexpr int kMaxNewtonSteps = 12;
constexpr int kMaxMarch = 16;
constexpr double kMinCosine = 0.2;       // between interpolated and face normal
constexpr double kMaxDistanceRatio = 3;  // of a foot's distance over the closest one
constexpr double kSettledWeight = 1e-10;
constexpr double kSettled = 1e-12;   // m
constexpr double kAhead = 1e-12;     // m^2, of rounding
constexpr double kMinAspect = 1e-9;  // twice the area over the longest edge squared

bool InRange(const std::array<std::uint8_t, 3>& corners, int point_count) {
  return corners[0] < point_count && corners[1] < point_count && corners[2] < point_count;
}

}  // namespace

void PatchSurface::Build(const SurfacePatch& patch) noexcept {
  triangle_count_ = 0;
  if (patch.triangle_count == 0) return;  // nothing reads the rest
  const int point_count = std::clamp(patch.point_count, 0, kMaxPoints);
  const int given = std::clamp(patch.triangle_count, 0, kMaxTriangles);
  std::array<double, kMaxPoints> rises;  // of the surface around, along the normal: > 0 in a hollow
  for (int i = 0; i < point_count; ++i) {
    points_W_[i] = patch.points[i].p_original_W;
    const Vector3d& n = patch.points[i].normal_W;
    const double length = n.norm();
    normals_W_[i] = length > 0.5 && length < 2 ? Vector3d(n / length) : Vector3d::Zero();
    bends_W_[i] = normals_W_[i];
    rises[static_cast<std::size_t>(i)] = 0;
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
    // A coordinate that is not finite makes the comparison false, so the triangle is left out.
    const bool usable = twice_area.norm() > kMinAspect * longest_squared && longest_squared > 0 &&
                        std::isfinite(longest_squared);
    const int slot = triangle_count_;
    for (int i = 0; i < 3; ++i) {
      left_of_[corners[i]][corners[(i + 1) % 3]] =
          usable ? static_cast<std::uint8_t>(slot) : kLeftOut;
    }
    if (!usable) continue;
    const Vector3d centre = (a + b + c) / 3;
    triangles_[slot] = corners;
    mesh_triangles_[slot] = patch.mesh_triangles[t];
    face_normals_W_[slot] = twice_area.normalized();
    centre_x_[slot] = centre.x();
    centre_y_[slot] = centre.y();
    centre_z_[slot] = centre.z();
    radius_[slot] = std::sqrt(std::max(
        {(a - centre).squaredNorm(), (b - centre).squaredNorm(), (c - centre).squaredNorm()}));
    for (const std::uint8_t corner : corners) {
      if (normals_W_[corner].dot(face_normals_W_[slot]) < kSmoothCosine) bends_W_[corner].setZero();
      rises[corner] += normals_W_[corner].dot(centre - points_W_[corner]);
    }
    ++triangle_count_;
  }
  for (int i = 0; i < point_count; ++i) {
    is_notch_[i] = bends_W_[i].isZero(0) && rises[static_cast<std::size_t>(i)] > 0;
  }
  BoundOffset();
}

// |n . (v - p)| is at most sin(turn) times the longest way within the triangle.
void PatchSurface::BoundOffset() {
  largest_offset_ = 0;
  for (int t = 0; t < triangle_count_; ++t) {
    for (const std::uint8_t corner : triangles_[t]) {
      const double sine = bends_W_[corner].cross(face_normals_W_[t]).norm();
      largest_offset_ = std::max(largest_offset_, sine * radius_[t]);
    }
  }
}

Vector3d PatchSurface::Offset(const SurfaceFoot& foot) const noexcept {
  const auto& [a, b, c] = foot.corners;
  return CurvedOffset({points_W_[a], points_W_[b], points_W_[c]},
                      {bends_W_[a], bends_W_[b], bends_W_[c]}, foot.weights);
}

Vector3d PatchSurface::Turn(const SurfaceFoot& foot, const Vector3d& d_W) const noexcept {
  const auto& [a, b, c] = foot.corners;
  const Vector3d &p = points_W_[a], &n = face_normals_W_[foot.triangle];
  const std::array<Vector3d, 3> normals_W = CornerNormals(foot.triangle);
  const Vector3d e1 = points_W_[b] - p, e2 = points_W_[c] - p;
  const double area = e1.cross(e2).dot(n);
  return d_W.cross(e2).dot(n) / area * (normals_W[1] - normals_W[0]) +
         e1.cross(d_W).dot(n) / area * (normals_W[2] - normals_W[0]);
}

bool PatchSurface::FindFoot(const Vector3d& c_W, double reach, SurfaceFoot* foot) const noexcept {
  const Closest closest = FindClosest(c_W);
  if (closest.triangle < 0) return false;

  const Vector3d& face_normal = face_normals_W_[closest.triangle];
  const Vector3d normal = NormalAt(closest.triangle, closest.weights);
  const bool inside_face = closest.weights.minCoeff() > 0;
  const bool outside = closest.offset_W.dot(inside_face ? face_normal : normal) >= 0;
  if (outside && closest.distance > reach + largest_offset_) return false;

  if (FollowNormals(c_W, closest, foot)) return foot->gap <= reach;

  if (IsOnBorder(triangles_[closest.triangle], closest.weights)) {
    const Vector3d sideways = closest.offset_W - closest.offset_W.dot(face_normal) * face_normal;
    if (sideways.norm() > kBorderTolerance) return false;
  }
  SetFoot(closest.triangle, closest.weights, foot);
  foot->gap = outside ? closest.distance : -closest.distance;
  foot->normal_W = closest.distance > kSettled ? Vector3d(closest.offset_W / foot->gap) : normal;
  foot->gap -= foot->normal_W.dot(Offset(*foot));
  return foot->gap <= reach;
}

bool PatchSurface::IsOutside(const Vector3d& c_W, double distance) const noexcept {
  const Closest closest = FindClosest(c_W);
  if (closest.triangle < 0 || IsOnBorder(triangles_[closest.triangle], closest.weights)) {
    return false;
  }
  return closest.distance > distance + largest_offset_ &&
         closest.offset_W.dot(NormalAt(closest.triangle, closest.weights)) > 0;
}

bool PatchSurface::FindBeside(const Vector3d& c_W, double reach,
                              std::span<const Vector3d> normals_W,
                              SurfaceFoot* foot) const noexcept {
  double nearest = reach + largest_offset_;
  bool found = false;
  for (int t = 0; t < triangle_count_; ++t) {
    const Vector3d to_centre_W(c_W.x() - centre_x_[t], c_W.y() - centre_y_[t],
                               c_W.z() - centre_z_[t]);
    const double above = to_centre_W.dot(face_normals_W_[t]);
    if (!(above > 0) || above > nearest || to_centre_W.norm() - radius_[t] > nearest) continue;
    const Closest closest = ClosestOn(t, c_W);
    if (!(closest.distance > kSettled) || closest.distance > nearest) continue;
    const Vector3d towards_W = closest.offset_W / closest.distance;
    if (towards_W.dot(face_normals_W_[t]) < kMinCosine || !IsApart(towards_W, normals_W)) continue;
    SurfaceFoot smooth;
    if (!IsLeast(closest) || !FollowNormals(c_W, closest, &smooth)) continue;
    if (!(smooth.gap > 0) || smooth.gap > reach || !IsApart(smooth.normal_W, normals_W)) continue;
    nearest = closest.distance;
    *foot = smooth;
    found = true;
  }
  return found;
}

// True if no triangle around the point is nearer to c: a point of a convex set is the closest one
// to c if no corner lies ahead of it towards c.
bool PatchSurface::IsLeast(const Closest& closest) const {
  const Corners& corners = triangles_[closest.triangle];
  const Vector3d p_W = Interpolated(points_W_, corners, closest.weights);
  const auto around = [&](int t) {
    const Corners& other = triangles_[t];
    for (std::size_t k = 0; k < 3; ++k) {
      if (closest.weights[static_cast<Eigen::Index>(k)] == 0) continue;
      if (std::find(other.begin(), other.end(), corners[k]) == other.end()) return false;
    }
    return true;
  };
  for (int t = 0; t < triangle_count_; ++t) {
    if (!around(t)) continue;
    for (const std::uint8_t corner : triangles_[t]) {
      if (closest.offset_W.dot(points_W_[corner] - p_W) > kAhead) return false;
    }
  }
  return true;
}

bool PatchSurface::FindNearest(const Vector3d& a_W, const Vector3d& b_W,
                               SegmentFoot* near) const noexcept {
  std::array<double, kMaxTriangles> bound;  // no part of the triangle is nearer
  int first = -1;
  for (int t = 0; t < triangle_count_; ++t) {
    const Vector3d centre_W(centre_x_[t], centre_y_[t], centre_z_[t]);
    const double along = ClosestOnSegment(centre_W, a_W, b_W);
    bound[t] = (centre_W - a_W - along * (b_W - a_W)).norm() - radius_[t];
    if (first < 0 || bound[t] < bound[first]) first = t;
  }
  if (first < 0) return false;
  near->distance = std::numeric_limits<double>::infinity();
  const auto try_triangle = [&](int t) {
    const Corners& corners = triangles_[t];
    const SegmentTrianglePair pair = ClosestSegmentTriangle(
        a_W, b_W, points_W_[corners[0]], points_W_[corners[1]], points_W_[corners[2]]);
    const double distance = std::sqrt(pair.squared_distance);
    if (distance >= near->distance) return;
    near->distance = distance;
    near->along = pair.along;
    near->foot.triangle = t;
    near->foot.weights = pair.on_triangle.barycentric;
  };
  try_triangle(first);
  for (int t = 0; t < triangle_count_; ++t) {
    if (t != first && bound[t] < near->distance) try_triangle(t);
  }
  const int triangle = near->foot.triangle;
  SetFoot(triangle, near->foot.weights, &near->foot);
  const Vector3d offset_W = a_W + near->along * (b_W - a_W) - Position(near->foot);
  const double height = offset_W.dot(near->foot.normal_W);
  near->outside = near->distance > 0 && height > 0;
  near->foot.gap = near->outside ? near->distance : -near->distance;
  if (!IsOnBorder(near->foot)) return true;
  const Vector3d sideways_W =
      offset_W - offset_W.dot(face_normals_W_[triangle]) * face_normals_W_[triangle];
  return sideways_W.norm() <= kBorderTolerance;
}

bool PatchSurface::FindEntry(const Vector3d& a_W, const Vector3d& b_W,
                             SurfaceFoot* foot) const noexcept {
  const Vector3d way = b_W - a_W;
  double earliest = std::numeric_limits<double>::infinity();
  for (int t = 0; t < triangle_count_; ++t) {
    const Corners& corners = triangles_[t];
    const Vector3d &p0 = points_W_[corners[0]], &n = face_normals_W_[t];
    const double slope = way.dot(n);
    if (!(slope < 0)) continue;
    const double along = (p0 - a_W).dot(n) / slope;
    if (!(along >= 0 && along <= 1 && along < earliest)) continue;
    const Vector3d e1 = points_W_[corners[1]] - p0, e2 = points_W_[corners[2]] - p0;
    const Vector3d offset = a_W + along * way - p0;
    const double area = e1.cross(e2).dot(n);
    const double w1 = offset.cross(e2).dot(n) / area, w2 = e1.cross(offset).dot(n) / area;
    if (std::min({w1, w2, 1 - w1 - w2}) < 0) continue;
    earliest = along;
    SetFoot(t, Vector3d(1 - w1 - w2, w1, w2), foot);
  }
  return earliest <= 1;
}

bool PatchSurface::Has(int mesh_triangle) const noexcept { return Slot(mesh_triangle) >= 0; }

// Returns the index of a triangle of the organ's mesh; -1 if the patch does not have it.
int PatchSurface::Slot(int mesh_triangle) const {
  for (int t = 0; t < triangle_count_ && mesh_triangle >= 0; ++t) {
    if (mesh_triangles_[t] == mesh_triangle) return t;
  }
  return -1;
}

bool PatchSurface::Find(int mesh_triangle, const Vector3d& weights, const Vector3d& p_W,
                        SurfaceFoot* foot) const noexcept {
  const int slot = Slot(mesh_triangle);
  if (slot >= 0) {
    SetFoot(slot, weights, foot);
    return true;
  }
  const Closest closest = FindClosest(p_W);
  if (closest.triangle < 0 || closest.distance > kSameFoot) return false;
  SetFoot(closest.triangle, closest.weights, foot);
  return true;
}

void PatchSurface::Walk(const Vector3d& d_W, SurfaceFoot* foot) const noexcept {
  int triangle = foot->triangle;
  Vector3d weights = foot->weights;
  Vector3d left = d_W;  // remaining displacement
  for (int march = 0; march < kMaxMarch; ++march) {
    const Corners& corners = triangles_[triangle];
    const Vector3d &p0 = points_W_[corners[0]], &n = face_normals_W_[triangle];
    const Vector3d e1 = points_W_[corners[1]] - p0, e2 = points_W_[corners[2]] - p0;
    const double area = e1.cross(e2).dot(n);
    Vector3d change(0, left.cross(e2).dot(n) / area, e1.cross(left).dot(n) / area);
    change[0] = -change[1] - change[2];
    // Move to the first edge in the way.
    double along = 1;
    int edge = -1;
    for (int i = 0; i < 3; ++i) {
      if (!(change[i] < 0) || weights[i] + along * change[i] >= kInside) continue;
      along = std::max(-weights[i] / change[i], 0.0);
      edge = i;
    }
    weights += along * change;
    if (edge < 0) break;
    weights[edge] = 0;
    left *= 1 - along;
    const std::uint8_t from = corners[(edge + 1) % 3], to = corners[(edge + 2) % 3];
    const std::uint8_t next = left_of_[to][from];
    if (next >= triangle_count_) {  // along the border
      const Vector3d direction = (points_W_[to] - points_W_[from]).normalized();
      const Vector3d rest = left.dot(direction) * direction;
      if ((left - rest).norm() < kSettled) break;  // already along the border
      left = rest;
      continue;
    }
    const double w_from = weights[(edge + 1) % 3], w_to = weights[(edge + 2) % 3];
    triangle = next;
    for (int i = 0; i < 3; ++i) {
      const std::uint8_t corner = triangles_[next][i];
      weights[i] = corner == from ? w_from : corner == to ? w_to : 0;
    }
  }
  weights = weights.cwiseMax(0.0);
  SetFoot(triangle, weights / weights.sum(), foot);
}

// Sets all fields but the gap.
void PatchSurface::SetFoot(int triangle, const Vector3d& weights, SurfaceFoot* foot) const {
  foot->triangle = triangle;
  foot->mesh_triangle = mesh_triangles_[triangle];
  foot->corners = triangles_[triangle];
  foot->weights = weights;
  foot->normal_W = NormalAt(triangle, weights);
}

// Returns the normals to be interpolated over a triangle. A tip never reaches the bottom of a notch, so
// each of its walls keeps its own there.
std::array<Vector3d, 3> PatchSurface::CornerNormals(int triangle) const {
  std::array<Vector3d, 3> normals_W;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint8_t corner = triangles_[triangle][k];
    normals_W[k] = is_notch_[corner] ? face_normals_W_[triangle] : normals_W_[corner];
  }
  return normals_W;
}

// Returns the interpolated normal; the face's own if vertex normals are opposed or missing.
Vector3d PatchSurface::NormalAt(int triangle, const Vector3d& weights) const {
  const std::array<Vector3d, 3> n = CornerNormals(triangle);
  const Vector3d normal = weights[0] * n[0] + weights[1] * n[1] + weights[2] * n[2];
  const double length = normal.norm();
  return length > kMinCosine ? Vector3d(normal / length) : face_normals_W_[triangle];
}

PatchSurface::Closest PatchSurface::ClosestOn(int triangle, const Vector3d& c_W) const {
  const Corners& corners = triangles_[triangle];
  const Vector3d weights =
      ClosestOnTriangle(c_W, points_W_[corners[0]], points_W_[corners[1]], points_W_[corners[2]])
          .barycentric;
  const Vector3d offset = c_W - Interpolated(points_W_, corners, weights);
  return {triangle, weights, offset, offset.norm()};
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
    const Closest closest = ClosestOn(t, c_W);
    if (closest.distance < best.distance) best = closest;
  };
  // The triangle with the nearest centre gives a bound that excludes most others.
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

bool PatchSurface::SolveOnTriangle(const Vector3d& c_W, int triangle, Vector3d* weights, double* t,
                                   Vector3d* n) const {
  const Corners& corners = triangles_[triangle];
  const std::array<Vector3d, 3> normals_W = CornerNormals(triangle);
  const Vector3d &p0 = points_W_[corners[0]], &n0 = normals_W[0];
  const Vector3d e1 = points_W_[corners[1]] - p0, e2 = points_W_[corners[2]] - p0;
  const Vector3d m1 = normals_W[1] - n0, m2 = normals_W[2] - n0;
  double w1 = (*weights)[1], w2 = (*weights)[2];
  bool settled = false;
  for (int step = 0; step < kMaxNewtonSteps && !settled; ++step) {
    *n = n0 + w1 * m1 + w2 * m2;
    const Vector3d missing = c_W - (p0 + w1 * e1 + w2 * e2) - *t * *n;
    const Vector3d c1 = e1 + *t * m1, c2 = e2 + *t * m2;
    const Vector3d c1_c2 = c1.cross(c2);
    const double determinant = c1_c2.dot(*n);
    // Positive: the offset surface has not folded over, c lies before the centre of curvature.
    if (!(determinant > kMinArea * e1.cross(e2).dot(*n))) return false;
    const double d1 = missing.dot(c2.cross(*n)) / determinant;
    const double d2 = missing.dot(n->cross(c1)) / determinant;
    const double dt = missing.dot(c1_c2) / determinant;
    w1 += d1;
    w2 += d2;
    *t += dt;
    settled = std::abs(d1) + std::abs(d2) < kSettledWeight && std::abs(dt) < kSettled;
  }
  *weights = Vector3d(1 - w1 - w2, w1, w2);
  *n = n0 + w1 * m1 + w2 * m2;
  return settled;
}

bool PatchSurface::FollowNormals(const Vector3d& c_W, const Closest& start,
                                 SurfaceFoot* foot) const {
  int triangle = start.triangle;
  Vector3d weights = start.weights;
  const std::array<Vector3d, 3> start_W = CornerNormals(triangle);
  double t = start.offset_W.dot(weights[0] * start_W[0] + weights[1] * start_W[1] +
                                weights[2] * start_W[2]);
  for (int march = 0; march < kMaxMarch; ++march) {
    Vector3d n;
    if (!SolveOnTriangle(c_W, triangle, &weights, &t, &n)) return false;
    int lowest = 0;
    const double least = weights.minCoeff(&lowest);
    if (least >= kInside) {
      const double length = n.norm();
      if (n.dot(face_normals_W_[triangle]) < kMinCosine * length) return false;
      if (std::abs(t) * length > kMaxDistanceRatio * start.distance + kSettled) return false;
      SetFoot(triangle, weights, foot);
      foot->normal_W = n / length;
      foot->gap = t * length - foot->normal_W.dot(Offset(*foot));
      return true;
    }
    // Crosses the edge opposite the lowest weight, at the point where the foot leaves the triangle.
    const Corners& corners = triangles_[triangle];
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

bool PatchSurface::Covers(const Vector3d& p_W) const noexcept {
  const Closest closest = FindClosest(p_W);
  return closest.triangle >= 0 && !IsOnBorder(triangles_[closest.triangle], closest.weights);
}

// A walk along an edge leaves its weight at about 1e-17.
bool PatchSurface::IsOnBorder(const SurfaceFoot& foot) const noexcept {
  return IsOnBorder(foot.corners, (foot.weights.array() < -kInside).select(0, foot.weights));
}

bool PatchSurface::IsOnBorder(const Corners& corners, const Vector3d& weights) const {
  int zeros = 0, zero = 0, one = 0;
  for (int i = 0; i < 3; ++i) {
    if (weights[i] == 0) {
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
  // A vertex is on the border if one of its edges has a triangle on one side only.
  const std::uint8_t vertex = corners[one];
  for (int other = 0; other < kMaxPoints; ++other) {
    if ((left_of_[vertex][other] == kNone) != (left_of_[other][vertex] == kNone)) return true;
  }
  return false;
}

}  // namespace hpdm
