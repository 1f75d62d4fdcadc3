#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/base/room.h"
#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A point of a surface triangle with its share of a load.
struct SurfaceSample {
  int triangle = 0;
  Vector3d barycentric = Vector3d::Zero();  ///< Weights of the triangle's corners; sum to one.
  double weight = 0;                        ///< Share of the load, > 0.
};

/// Samples the load patch of radius R around a point. Its weight is the kernel cos(pi d / 2R) of
/// the distance d < R to the point, integrated over the surface's area. The weights sum to one.
///
/// 1. Triangles are split until their sides are at most `resolution` x R. So the samples follow the
///    surface, not its triangulation, and a patch inside one triangle works too.
/// 2. Only triangles whose normal is less than 90 degrees from that of the nearest surface point
///    take part. The other side of a thin wall or of a sharp edge does not.
///
/// `point`: in the mesh's frame, m, less than R from the surface. Deterministic; set-up only.
/// Throws InputError if no surface lies within the radius.
std::vector<SurfaceSample> SurfaceKernel(const SurfaceMesh& mesh, const Vector3d& point,
                                         double radius, double resolution = 0.125);

/// The samples of a kernel in a fixed size, for the lattice row of a contact in a step. The weights
/// sum to one.
struct KernelSamples {
  KernelSamples() : samples(Samples::kUntouched) {}
  KernelSamples(const KernelSamples& other) : KernelSamples() { *this = other; }
  KernelSamples& operator=(const KernelSamples& other) {
    sample_count = other.sample_count;
    samples.Take(other.samples, sample_count);
    return *this;
  }

  static constexpr int kMaxSamples = 2560;     ///< About 250 on triangles larger than the kernel.
  static constexpr double kResolution = 0.25;  ///< Longest side of a sample's part, of the radius.
  int sample_count = 0;
  using Samples = Room<SurfaceSample, kMaxSamples>;
  Samples samples;
};

/// The same, also gathered at the surface's vertices, for means of quantities at vertices. The
/// vertices' weights sum to one too.
struct KernelPatch : KernelSamples {
  static constexpr int kMaxVertices = 160;
  int vertex_count = 0;
  std::array<int, kMaxVertices> vertices;
  std::array<double, kMaxVertices> weights;
};

/// Samples the kernel about `at` for a step. It covers the triangles of `around` (collected around
/// `at`) whose rest normals are less than 90 degrees from `facing`. Distances, areas and normals
/// are those of `mesh`, at rest. If edges are short beside the radius, the kernel is cut at the
/// border of `around`. If the samples run out, parts count unsplit. Deformation thread; bounded,
/// allocates nothing.
void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelSamples* kernel) noexcept;
void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelPatch* kernel) noexcept;

/// Samples the surface of `around` within `reach` (m) of the point `at`, for a step. The weights
/// are areas, m^2, of parts with sides of at most `longest_side` (m). Takes the triangles that face
/// less than 90 degrees from `facing`. If the samples run out, parts count unsplit. Deformation
/// thread; bounded, allocates nothing.
void GatherSurface(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                   const Vector3d& facing, double reach, double longest_side,
                   KernelSamples* samples) noexcept;

/// Samples the surface inside a region (support.h; `bounds` for fractions), or all of it. The
/// weights are areas, m^2. Triangles are split until their sides are at most `longest_side` (m);
/// the centroid of a part decides whether it counts. Deterministic; set-up only. Throws InputError
/// if the region contains no surface.
std::vector<SurfaceSample> SurfaceInRegion(const SurfaceMesh& mesh,
                                           const std::optional<Region>& region, const Box& bounds,
                                           double longest_side);

/// Returns the surface point nearest to `point` (m); triangle -1 for a mesh without triangles.
/// O(F).
SurfacePoint NearestSurfacePoint(const SurfaceMesh& mesh, const Vector3d& point);

/// Interpolates `vertices` (V x 3) at a sample: rest positions, displaced ones or displacements.
Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices);

}  // namespace hpdm
