#pragma once

#include <optional>
#include <vector>

#include "engine/base/types.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A load on a surface, by sample points.
struct PlacementLoad {
  Points points;                           ///< S x 3, m, world.
  Points normals;                          ///< S x 3, unit, outwards.
  Eigen::VectorXd weights;                 ///< S, sum to one.
  Points forces;                           ///< S x 3, N; zero where `displacement_W` is given.
  std::optional<Vector3d> displacement_W;  ///< m, of the weighted mean.
};

/// Loads that act together.
using PlacementCase = std::vector<PlacementLoad>;

/// Returns the load cases for which the functions of an organ are placed: all its loads together, or
/// without loads a press of 1 N at each of `presses` points, spread over the surface outside of
/// fixed supports.
///
/// `rest`: posed, m; `normals`: V x 3, unit; `least_radius`: m, the smallest patch that the finest
/// functions resolve. Deterministic; set-up only. Throws InputError if a load touches no surface.
std::vector<PlacementCase> PlacementCases(const OrganOptions& organ, const SurfaceMesh& rest,
                                          const Points& normals, double least_radius, int presses);

}  // namespace hpdm
