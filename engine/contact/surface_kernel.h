#pragma once

#include <array>
#include <optional>
#include <vector>

#include "engine/mesh/collision.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/mesh/surface_topology.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A point of a surface triangle that carries part of a load.
struct SurfaceSample {
  int triangle = 0;
  Vector3d barycentric = Vector3d::Zero();  ///< Of the triangle's corners; sums to one.
  double weight = 0;                        ///< Share of the load, > 0.
};

/// The load patch of radius R around a point: the kernel cos(pi d / 2R) of the distance d < R to
/// the point, integrated over the surface's area and normalised, so that the weights sum to one.
/// Triangles are split until their sides are at most `resolution` x R, so the samples follow the
/// surface and not its triangulation; a patch inside one triangle works as well.
///
/// Only triangles that face as the surface nearest to the point does take part (their normals are
/// less than 90 degrees apart): the other side of a thin wall or a sharp edge does not.
///
/// `point` in the mesh's frame, m; at most R away from the surface. Deterministic; set-up only.
/// Throws InputError when no surface lies within the radius.
std::vector<SurfaceSample> SurfaceKernel(const SurfaceMesh& mesh, const Vector3d& point,
                                         double radius, double resolution = 0.125);

/// The same kernel as a step needs it, of fixed size: samples by their rest positions, for lattice
/// rows, and gathered at the surface's vertices, for means of what vertices carry. Either's weights
/// sum to one.
struct KernelSamples {
  static constexpr int kMaxSamples = 2560;     ///< About 250 on triangles larger than the kernel.
  static constexpr double kResolution = 0.25;  ///< Longest side of a sample's part, of the radius.
  int sample_count = 0;
  std::array<SurfaceSample, kMaxSamples> samples;
};

/// The same with the share of each vertex.
struct KernelPatch : KernelSamples {
  static constexpr int kMaxVertices = 64;
  int vertex_count = 0;
  std::array<int, kMaxVertices> vertices;
  std::array<double, kMaxVertices> weights;
};

/// SurfaceKernel() for a step: about `at`, over the triangles of `around` (collected around it)
/// whose rest normals are less than 90 degrees from `facing`. Distances, areas and normals are
/// those of `mesh`, at rest. Where `around` ends before the kernel does (edges short beside the
/// radius) the kernel is cut there; when the samples run out parts count unsplit. Deformation
/// thread; bounded, allocates nothing.
void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelSamples* kernel) noexcept;
void GatherKernel(const SurfaceMesh& mesh, const Neighbourhood& around, const SurfacePoint& at,
                  const Vector3d& facing, double radius, KernelPatch* kernel) noexcept;

/// The surface inside a region (support.h; `bounds` for fractions), or all of it: weights are
/// areas, m^2. Triangles are split until their sides are at most `longest_side` (m), and each part
/// counts wholly or not, by its centroid. Deterministic; set-up only. Throws InputError when the
/// region holds no surface.
std::vector<SurfaceSample> SurfaceInRegion(const SurfaceMesh& mesh,
                                           const std::optional<Region>& region, const Box& bounds,
                                           double longest_side);

/// The point of the mesh nearest to `point` (m); triangle -1 for a mesh without triangles. O(F).
SurfacePoint NearestSurfacePoint(const SurfaceMesh& mesh, const Vector3d& point);

/// Where a sample lies among the vertices (V x 3): the mesh's own, displaced ones or displacements.
Vector3d AtSample(const SurfaceSample& sample, const Triangles& triangles, const Points& vertices);

}  // namespace hpdm
