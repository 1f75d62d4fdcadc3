#include "engine/contact/surface_kernel.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <sstream>
#include <utility>

#include "engine/base/error.h"
#include "engine/mesh/closest_point.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

using Corners = std::array<Vector3d, 3>;

/// Relative slack of every choice of the quadrature: which side is cut, whether one is, whether a
/// triangle faces the load. Equal sides and right angles are common, and their round-off depends on
/// the body's unit and position, so round-off must not decide.
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

// A part of a triangle that is still to be integrated.
struct Part {
  Corners points;
  Corners barycentric;
};

constexpr int kDepth = 64;  // most bisections; two or three of them halve the sides

// Integrates a density over a triangle by midpoint quadrature. Bisects the longest side until none
// is longer than `longest_side`. Leaves out parts with apart(centroid, side). Calls
// add(barycentric, area x density(centroid)) for the others if the product is positive. After
// `budget` calls the remaining parts count unsplit. No allocation: the stack holds one part for
// each bisection.
template <class Apart, class Density, class Add>
void Integrate(const Corners& corners, double longest_side, int* budget, const Apart& apart,
               const Density& density, const Add& add) {
  std::array<Part, kDepth> stack;
  int size = 0;
  stack[size++] = {corners, {Vector3d::UnitX(), Vector3d::UnitY(), Vector3d::UnitZ()}};
  while (size > 0) {
    const Part part = stack[--size];
    const auto& [a, b, c] = part.points;
    int longest = 0;
    double length = 0;
    for (int k = 0; k < 3; ++k) {
      const double side = (part.points[(k + 1) % 3] - part.points[k]).norm();
      if (side > length * (1 + kSlack)) {
        length = side;
        longest = k;
      }
    }
    const Vector3d centroid = (a + b + c) / 3;
    if (apart(centroid, length)) continue;
    if (length > longest_side * (1 + kSlack) && *budget > 0 && size + 2 <= kDepth) {
      const int i = longest, j = (longest + 1) % 3;
      Part& first = stack[size++] = part;
      Part& second = stack[size++] = part;
      first.points[j] = second.points[i] = (part.points[i] + part.points[j]) / 2;
      first.barycentric[j] = second.barycentric[i] =
          (part.barycentric[i] + part.barycentric[j]) / 2;
      continue;
    }
    const double weight = density(centroid) * (b - a).cross(c - a).norm() / 2;
    if (!(weight > 0)) continue;
    --*budget;
    add((part.barycentric[0] + part.barycentric[1] + part.barycentric[2]) / 3, weight);
  }
}

// Integrates the kernel about a point.
template <class Add>
void IntegrateKernel(const Vector3d& point, double radius, double resolution,
                     const Corners& corners, int* budget, const Add& add) {
  Integrate(
      corners, resolution * radius, budget,
      // No corner is farther from the centroid than two thirds of the longest side.
      [&](const Vector3d& centroid, double side) {
        return (centroid - point).norm() >= radius + side * 2 / 3;
      },
      [&](const Vector3d& centroid) {
        const double distance = (centroid - point).norm();
        return distance < radius ? std::cos(std::numbers::pi * distance / (2 * radius)) : 0.0;
      },
      add);
}

bool FacesAs(const Vector3d& facing, const Corners& c) {
  const Vector3d normal = (c[1] - c[0]).cross(c[2] - c[0]);
  return normal.dot(facing) > kSlack * normal.norm() * facing.norm();
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
      IntegrateKernel(point, radius, resolution, c, &budget,
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

SurfacePoint NearestSurfacePoint(const SurfaceMesh& mesh, const Vector3d& point) {
  const Nearest nearest = FindNearest(mesh, point);
  return {nearest.triangle, nearest.at.barycentric};
}

void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelSamples* kernel) noexcept {
  kernel->sample_count = 0;
  const Vector3d point = at.Position(mesh.vertices, mesh.triangles);
  // Leaves room for the unsplit parts on the stack and the remaining triangles.
  int budget = KernelSamples::kMaxSamples - kDepth - Neighbourhood::kMaxTriangles;
  double sum = 0;
  for (int i = 0; i < around.count; ++i) {
    const int t = around.triangles[i];
    const Corners c = CornersOf(mesh, t);
    if (!FacesAs(facing, c)) continue;
    IntegrateKernel(point, radius, KernelSamples::kResolution, c, &budget,
                    [&](const Vector3d& barycentric, double weight) {
                      kernel->samples[kernel->sample_count++] = {t, barycentric, weight};
                      sum += weight;
                    });
  }
  if (!(sum > 0)) {  // no triangle faces that way: use the point alone
    sum = 1;
    kernel->samples[kernel->sample_count++] = {at.triangle, at.barycentric, 1};
  }
  for (int i = 0; i < kernel->sample_count; ++i) kernel->samples[i].weight /= sum;
}

void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelPatch* kernel) noexcept {
  GatherKernel(mesh, around, at, facing, radius, static_cast<KernelSamples*>(kernel));
  kernel->vertex_count = 0;
  // The samples of a triangle follow each other.
  for (int s = 0; s < kernel->sample_count;) {
    const int triangle = kernel->samples[s].triangle;
    Vector3d weights = Vector3d::Zero();
    for (; s < kernel->sample_count && kernel->samples[s].triangle == triangle; ++s) {
      weights += kernel->samples[s].weight * kernel->samples[s].barycentric;
    }
    for (int k = 0; k < 3; ++k) {
      const int vertex = mesh.triangles(triangle, k);
      int i = 0;
      while (i < kernel->vertex_count && kernel->vertices[i] != vertex) ++i;
      if (i == KernelPatch::kMaxVertices) continue;
      if (i == kernel->vertex_count) {
        kernel->vertices[i] = vertex;
        kernel->weights[i] = 0;
        ++kernel->vertex_count;
      }
      kernel->weights[i] += weights[k];
    }
  }
}

void GatherSurface(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                   const Vector3d& facing, double reach, double longest_side,
                   KernelSamples* samples) noexcept {
  samples->sample_count = 0;
  const Vector3d point = at.Position(mesh.vertices, mesh.triangles);
  int budget = KernelSamples::kMaxSamples - kDepth - Neighbourhood::kMaxTriangles;
  for (int i = 0; i < around.count; ++i) {
    const int t = around.triangles[i];
    const Corners c = CornersOf(mesh, t);
    if (!FacesAs(facing, c)) continue;
    Integrate(
        c, longest_side, &budget,
        [&](const Vector3d& centroid, double side) {
          return (centroid - point).norm() >= reach + side * 2 / 3;
        },
        [&](const Vector3d& centroid) { return (centroid - point).norm() < reach ? 1.0 : 0.0; },
        [&](const Vector3d& barycentric, double area) {
          samples->samples[samples->sample_count++] = {t, barycentric, area};
        });
  }
}

std::vector<SurfaceSample> SurfaceInRegion(const SurfaceMesh& mesh,
                                           const std::optional<Region>& region, const Box& bounds,
                                           double longest_side) {
  std::vector<SurfaceSample> samples;
  int budget = std::numeric_limits<int>::max();
  for (int t = 0; t < mesh.triangles.rows(); ++t) {
    Integrate(
        CornersOf(mesh, t), longest_side, &budget, [](const Vector3d&, double) { return false; },
        [&](const Vector3d& p) { return !region || InRegion(*region, bounds, p) ? 1.0 : 0.0; },
        [&](const Vector3d& barycentric, double area) {
          samples.push_back({t, barycentric, area});
        });
  }
  if (samples.empty()) {
    throw InputError("pressure: its region holds no surface; move or enlarge it");
  }
  return samples;
}

Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices) {
  Vector3d sum = Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    sum += sample.barycentric[k] * vertices.row(triangles(sample.triangle, k)).transpose();
  }
  return sum;
}

}  // namespace hpdm
