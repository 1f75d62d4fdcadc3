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

// The part of one triangle's barycentric domain that is still to be integrated.
struct Part {
  Corners points;
  Corners barycentric;
};

struct Kernel {
  Vector3d point;
  double radius;
  double longest_side;  // of a part that counts as one sample
};

// Integrates the kernel over one triangle: bisects the longest side until it is short enough,
// leaving out what is beyond the radius, and calls `add(barycentric, area x kernel)` at the
// centroid of each part. After `budget` samples the parts left count unsplit. No allocation: the
// halves of a bisection are at least as deep as they are short, so the stack holds them.
template <class Add>
void Integrate(const Kernel& kernel, const Corners& corners, int* budget, const Add& add) {
  constexpr int kDepth = 64;  // side / 2^(64 / 3): any triangle in double precision
  std::array<Part, kDepth> stack;
  int size = 0;
  stack[size++] = {corners, {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}};
  while (size > 0) {
    const Part part = stack[--size];
    const auto& [a, b, c] = part.points;
    int longest = 0;
    double length2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double side2 = (part.points[(k + 1) % 3] - part.points[k]).squaredNorm();
      if (side2 > length2) {
        length2 = side2;
        longest = k;
      }
    }
    const double length = std::sqrt(length2);
    const double distance = ((a + b + c) / 3 - kernel.point).norm();
    // No corner is farther from the centroid than two thirds of the longest side.
    if (distance >= kernel.radius + length * 2 / 3) continue;
    if (length > kernel.longest_side && *budget > 0 && size + 2 <= kDepth) {
      const int i = longest, j = (longest + 1) % 3;
      Part& first = stack[size++] = part;
      Part& second = stack[size++] = part;
      first.points[j] = second.points[i] = (part.points[i] + part.points[j]) / 2;
      first.barycentric[j] = second.barycentric[i] =
          (part.barycentric[i] + part.barycentric[j]) / 2;
      continue;
    }
    const double area = (b - a).cross(c - a).norm() / 2;
    if (distance >= kernel.radius || area <= 0) continue;
    --*budget;
    add((part.barycentric[0] + part.barycentric[1] + part.barycentric[2]) / 3,
        area * std::cos(std::numbers::pi * distance / (2 * kernel.radius)));
  }
}

bool FacesAs(const Vector3d& facing, const Corners& c) {
  return (c[1] - c[0]).cross(c[2] - c[0]).dot(facing) > 0;
}

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
    std::vector<SurfaceSample> samples;
    double sum = 0;
    int budget = std::numeric_limits<int>::max();
    for (int t = 0; t < mesh.triangles.rows(); ++t) {
      const Corners c = CornersOf(mesh, t);
      if (!FacesAs(facing, c)) continue;
      Integrate({point, radius, resolution * radius}, c, &budget,
                [&](const Vector3d& barycentric, double weight) {
                  samples.push_back({t, barycentric, weight});
                  sum += weight;
                });
    }
    if (sum > 0) {
      for (SurfaceSample& sample : samples) sample.weight /= sum;
      return samples;
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

void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelWeights* kernel) noexcept {
  kernel->count = 0;
  const auto slot = [&](int vertex) -> double* {
    for (int i = 0; i < kernel->count; ++i) {
      if (kernel->vertices[i] == vertex) return &kernel->weights[i];
    }
    if (kernel->count == KernelWeights::kMaxVertices) return nullptr;
    kernel->vertices[kernel->count] = vertex;
    kernel->weights[kernel->count] = 0;
    return &kernel->weights[kernel->count++];
  };
  const auto add = [&](int triangle, const Vector3d& weights) {
    for (int k = 0; k < 3; ++k) {
      if (double* weight = slot(mesh.triangles(triangle, k))) *weight += weights[k];
    }
  };

  const Vector3d point = at.Position(mesh.vertices, mesh.triangles);
  int budget = KernelWeights::kMaxSamples;
  double sum = 0;
  for (int i = 0; i < around.count; ++i) {
    const int t = around.triangles[i];
    const Corners c = CornersOf(mesh, t);
    if (!FacesAs(facing, c)) continue;
    Vector3d over_triangle = Vector3d::Zero();
    Integrate({point, radius, KernelWeights::kResolution * radius}, c, &budget,
              [&](const Vector3d& barycentric, double weight) {
                over_triangle += weight * barycentric;
                sum += weight;
              });
    if (over_triangle.sum() > 0) add(t, over_triangle);
  }
  if (sum > 0) {
    for (int i = 0; i < kernel->count; ++i) kernel->weights[i] /= sum;
  } else {
    add(at.triangle, at.barycentric);  // nothing faces that way: the point alone
  }
}

Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    sum += sample.barycentric[k] * vertices.row(triangles(sample.triangle, k)).transpose();
  }
  return sum;
}

}  // namespace hpdm
