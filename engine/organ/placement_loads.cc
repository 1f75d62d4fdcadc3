#include "engine/organ/placement_loads.h"

#include <algorithm>
#include <limits>

#include "engine/contact/surface_kernel.h"
#include "engine/tissue/support.h"

namespace hpdm {
namespace {

PlacementLoad AtSamples(const std::vector<SurfaceSample>& samples, const SurfaceMesh& rest,
                        const Points& normals) {
  const auto count = static_cast<Eigen::Index>(samples.size());
  PlacementLoad load{Points(count, 3), Points(count, 3), Eigen::VectorXd(count),
                     Points::Zero(count, 3), std::nullopt};
  for (Eigen::Index s = 0; s < count; ++s) {
    const SurfaceSample& sample = samples[static_cast<std::size_t>(s)];
    load.points.row(s) = AtSample(sample, rest.triangles, rest.vertices);
    load.normals.row(s) = AtSample(sample, rest.triangles, normals).normalized();
    load.weights[s] = sample.weight;
  }
  return load;
}

PlacementLoad PatchLoad(const LoadOptions& options, const SurfaceMesh& rest, const Points& normals,
                        double least_radius) {
  PlacementLoad load =
      AtSamples(SurfaceKernel(rest, options.p_centre_W, std::max(options.radius, least_radius)),
                rest, normals);
  if (options.force_W) load.forces = load.weights * options.force_W->transpose();
  load.displacement_W = options.displacement_W;
  return load;
}

PlacementLoad PressureLoad(const LoadOptions& options, const SurfaceMesh& rest,
                           const Points& normals, double longest_side) {
  const std::vector<SurfaceSample> samples =
      SurfaceInRegion(rest, options.region, AxisAlignedBounds(rest.vertices), longest_side);
  PlacementLoad load = AtSamples(samples, rest, normals);
  for (Eigen::Index s = 0; s < load.weights.size(); ++s) {
    const auto corner = [&](int k) -> Vector3d {
      return rest.vertices.row(rest.triangles(samples[static_cast<std::size_t>(s)].triangle, k));
    };
    const Vector3d across = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    load.forces.row(s) = -*options.pressure * load.weights[s] * across.transpose();
  }
  load.weights /= load.weights.sum();
  return load;
}

// Returns vertices spread over the surface, each the farthest one from those before it.
std::vector<Eigen::Index> SpreadVertices(const OrganOptions& organ, const SurfaceMesh& rest,
                                         int count) {
  const Box bounds = AxisAlignedBounds(rest.vertices);
  Eigen::VectorXd distance2(rest.vertices.rows());
  const Eigen::RowVector3d middle = rest.vertices.colwise().mean();
  for (Eigen::Index v = 0; v < rest.vertices.rows(); ++v) {
    distance2[v] = (rest.vertices.row(v) - middle).squaredNorm();
    for (const SupportOptions& support : organ.supports) {
      if (!support.stiffness && InRegion(support.region, bounds, rest.vertices.row(v))) {
        distance2[v] = -1;
      }
    }
  }
  std::vector<Eigen::Index> spread;
  Eigen::Index farthest = 0;
  for (; count > 0 && distance2.maxCoeff(&farthest) > 0; --count) {
    // The first one begins the distances to the others.
    if (spread.empty()) distance2 = (distance2.array() < 0).select(distance2, 1e300);
    const Eigen::RowVector3d p = rest.vertices.row(farthest);
    distance2 = distance2.cwiseMin((rest.vertices.rowwise() - p).rowwise().squaredNorm());
    spread.push_back(farthest);
  }
  return spread;
}

}  // namespace

std::vector<PlacementCase> PlacementCases(const OrganOptions& organ, const SurfaceMesh& rest,
                                          const Points& normals, double least_radius, int presses) {
  std::vector<PlacementCase> cases;
  if (!organ.loads.empty()) {
    PlacementCase& together = cases.emplace_back();
    for (const LoadOptions& load : organ.loads) {
      together.push_back(load.pressure ? PressureLoad(load, rest, normals, least_radius / 2)
                                       : PatchLoad(load, rest, normals, least_radius));
    }
    return cases;
  }
  for (const Eigen::Index v : SpreadVertices(organ, rest, presses)) {
    LoadOptions press;
    press.p_centre_W = rest.vertices.row(v);
    press.radius = least_radius;
    press.force_W = -normals.row(v).transpose();
    cases.push_back({PatchLoad(press, rest, normals, least_radius)});
  }
  return cases;
}

}  // namespace hpdm
