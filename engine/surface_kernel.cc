#include "engine/surface_kernel.h"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "engine/closest_point.h"
#include "engine/error.h"

namespace hpdm {
namespace {

using Corners = std::array<Vector3d, 3>;

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

class Patch {
 public:
  Patch(const Vector3d& point, double radius, double longest_side)
      : point_(point), radius_(radius), longest_side_(longest_side) {}

  /// Bisects the longest side until it is short enough, leaving out what is beyond the radius;
  /// each part counts with the kernel at its centroid.
  void Add(int triangle, const Part& part) {
    const auto& [a, b, c] = part.points;
    if ((ClosestOnTriangle(point_, a, b, c).point - point_).norm() >= radius_) return;
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k) {
      const double side = (part.points[(k + 1) % 3] - part.points[k]).norm();
      if (side > length) {
        length = side;
        longest = k;
      }
    }
    if (length > longest_side_) {
      const int i = longest, j = (longest + 1) % 3;
      Part first = part, second = part;
      first.points[j] = second.points[i] = (part.points[i] + part.points[j]) / 2;
      first.barycentric[j] = second.barycentric[i] =
          (part.barycentric[i] + part.barycentric[j]) / 2;
      Add(triangle, first);
      Add(triangle, second);
      return;
    }
    const double distance = ((a + b + c) / 3 - point_).norm();
    const double area = (b - a).cross(c - a).norm() / 2;
    if (distance >= radius_ || area <= 0) return;
    const double kernel = std::cos(std::numbers::pi * distance / (2 * radius_));
    samples.push_back({triangle,
                       (part.barycentric[0] + part.barycentric[1] + part.barycentric[2]) / 3,
                       area * kernel});
  }

  std::vector<SurfaceSample> samples;

 private:
  Vector3d point_;
  double radius_;
  double longest_side_;
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
    Patch patch(point, radius, resolution * radius);
    const Corners unit = {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()};
    for (int t = 0; t < mesh.triangles.rows(); ++t) {
      const Corners c = CornersOf(mesh, t);
      if ((c[1] - c[0]).cross(c[2] - c[0]).dot(facing) > 0) patch.Add(t, {c, unit});
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

Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    sum += sample.barycentric[k] * vertices.row(triangles(sample.triangle, k)).transpose();
  }
  return sum;
}

}  // namespace hpdm
