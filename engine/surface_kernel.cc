#include "engine/surface_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

#include "engine/closest_point.h"
#include "engine/error.h"
#include "engine/support.h"

namespace hpdm {
namespace {

using Corners = std::array<Vector3d, 3>;

/// Slack of every choice between two quadratures (which side is cut, whether one is, whether a
/// triangle faces the load), relative to what is compared: equal sides and right angles are common,
/// and round-off, which depends on the body's unit and place, must not choose for them. Lengths
/// differ by it only by accident.
constexpr double kSlack = 1e-9;

Corners CornersOf(const SurfaceMesh& mesh, int triangle) {
  Corners corners;
  for (int k = 0; k < 3; ++k) {
    corners[k] = mesh.vertices.row(mesh.triangles(triangle, k)).transpose();
  }
  return corners;
}

struct Nearest {
  int triangle = -1;
  TrianglePoint at;
  double distance = std::numeric_limits<double>::infinity();
};

Nearest FindNearest(const SurfaceMesh& mesh, const Vector3d& point) {
  Nearest nearest;
  for (int t = 0; t < mesh.triangles.rows(); ++t) {
    const Corners c = CornersOf(mesh, t);
    const TrianglePoint at = ClosestOnTriangle(point, c[0], c[1], c[2]);
    const double distance = (at.point - point).norm();
    if (distance < nearest.distance) nearest = {t, at, distance};
  }
  return nearest;
}

/// The part of one triangle's barycentric domain that is still to be integrated.
struct Part {
  Corners points;
  Corners barycentric;
};

/// Splits triangles into parts that count with a density at their centroids.
class Patch {
 public:
  /// `apart(a, b, c)`: the density is zero all over that part.
  Patch(double longest_side,
        std::function<bool(const Vector3d&, const Vector3d&, const Vector3d&)> apart,
        std::function<double(const Vector3d&)> density)
      : longest_side_(longest_side), apart_(std::move(apart)), density_(std::move(density)) {}

  void Add(int triangle, const Corners& corners) {
    AddPart(triangle, {corners, {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}});
  }

  std::vector<SurfaceSample> samples;

 private:
  /// Bisects the longest side until it is short enough.
  void AddPart(int triangle, const Part& part) {
    const auto& [a, b, c] = part.points;
    if (apart_(a, b, c)) return;
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k) {
      const double side = (part.points[(k + 1) % 3] - part.points[k]).norm();
      if (side > length * (1 + kSlack)) {
        length = side;
        longest = k;
      }
    }
    if (length > longest_side_ * (1 + kSlack)) {
      const int i = longest, j = (longest + 1) % 3;
      Part first = part, second = part;
      first.points[j] = second.points[i] = (part.points[i] + part.points[j]) / 2;
      first.barycentric[j] = second.barycentric[i] =
          (part.barycentric[i] + part.barycentric[j]) / 2;
      AddPart(triangle, first);
      AddPart(triangle, second);
      return;
    }
    const double weight = density_((a + b + c) / 3) * (b - a).cross(c - a).norm() / 2;
    if (!(weight > 0)) return;
    samples.push_back(
        {triangle, (part.barycentric[0] + part.barycentric[1] + part.barycentric[2]) / 3, weight});
  }

  double longest_side_;
  std::function<bool(const Vector3d&, const Vector3d&, const Vector3d&)> apart_;
  std::function<double(const Vector3d&)> density_;
};

}  // namespace

std::vector<SurfaceSample> SurfaceKernel(const SurfaceMesh& mesh, const Vector3d& point,
                                         double radius, double resolution) {
  const Nearest nearest = FindNearest(mesh, point);
  if (nearest.distance < radius) {
    Points normals;
    VertexNormals(mesh.vertices, mesh.triangles, &normals);
    Vector3d facing = Vector3d::Zero();
    for (int k = 0; k < 3; ++k) {
      facing +=
          nearest.at.barycentric[k] * normals.row(mesh.triangles(nearest.triangle, k)).transpose();
    }
    Patch patch(
        resolution * radius,
        [&](const Vector3d& a, const Vector3d& b, const Vector3d& c) {
          return (ClosestOnTriangle(point, a, b, c).point - point).norm() >= radius;
        },
        [&](const Vector3d& p) {
          const double distance = std::min((p - point).norm(), radius);
          return std::cos(std::numbers::pi * distance / (2 * radius));
        });
    for (int t = 0; t < mesh.triangles.rows(); ++t) {
      const Corners c = CornersOf(mesh, t);
      const Vector3d normal = (c[1] - c[0]).cross(c[2] - c[0]);
      if (normal.dot(facing) > kSlack * normal.norm() * facing.norm()) patch.Add(t, c);
    }
    double sum = 0;
    for (const SurfaceSample& sample : patch.samples) sum += sample.weight;
    if (sum > 0) {
      for (SurfaceSample& sample : patch.samples) sample.weight /= sum;
      return patch.samples;
    }
  }
  std::ostringstream message;
  message << "load at [" << point.transpose() << "]: no surface within its radius of " << radius
          << " m; ";
  if (nearest.triangle < 0) {
    message << "the mesh has no triangles";
  } else {
    message << "move it to [" << nearest.at.point.transpose() << "], the nearest point";
  }
  throw InputError(message.str());
}

SurfacePoint NearestSurfacePoint(const SurfaceMesh& mesh, const Vector3d& point) {
  const Nearest nearest = FindNearest(mesh, point);
  return {nearest.triangle, nearest.at.barycentric};
}

std::vector<SurfaceSample> SurfaceInRegion(const SurfaceMesh& mesh,
                                           const std::optional<Region>& region, const Box& bounds,
                                           double longest_side) {
  Patch patch(
      longest_side, [](const Vector3d&, const Vector3d&, const Vector3d&) { return false; },
      [&](const Vector3d& p) { return !region || InRegion(*region, bounds, p) ? 1.0 : 0.0; });
  for (int t = 0; t < mesh.triangles.rows(); ++t) patch.Add(t, CornersOf(mesh, t));
  if (patch.samples.empty()) {
    throw InputError("pressure: its region holds no surface; move or enlarge it");
  }
  return patch.samples;
}

Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    sum += sample.barycentric[k] * vertices.row(triangles(sample.triangle, k)).transpose();
  }
  return sum;
}

}  // namespace hpdm
