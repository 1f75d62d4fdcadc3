#pragma once

#include "engine/reference_fem/tetra_mesh.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {

/// A cube with walls around nothing, for what a lattice is worst at.
struct HollowBody {
  OrganOptions organ;
  SurfaceMesh rest;
  std::vector<LoadOptions> loads;
  TetraMesh tetrahedra;  ///< Linear: the wall one brick thick, ten bricks an edge.
};

/// `edge` and `wall` in m; a lattice of `cells` per axis. Its lowest tenth is held, the middle of
/// its top pressed over 15 mm.
HollowBody HollowBox(double edge, double wall, int cells);

/// With its own tetrahedra, linear or quadratic.
StressAnswer TetraRest(const HollowBody& body, bool quadratic);

}  // namespace hpdm
