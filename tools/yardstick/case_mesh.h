#pragma once

#include "engine/reference_fem/tetra_mesh.h"
#include "tools/shared/static_case.h"

namespace hpdm {

/// Where a case's tetrahedra are smaller than elsewhere.
enum class Grading {
  kEven,              ///< Nowhere.
  kLoads,             ///< From the organ's length over 15 to a third of the radius at the loads.
  kLoadsAndSupports,  ///< And towards the supports' borders, where the stress is singular.
};

/// Fills a case's organ with linear tetrahedra of about that many nodes, within 6 % where six tries
/// reach it. The mesh's surface keeps within `distance` of a far element's size.
TetraMesh MeshOf(const StaticCase& load_case, int nodes, Grading grading, double distance);

}  // namespace hpdm
