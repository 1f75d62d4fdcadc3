#pragma once

#include "engine/reference_fem/tetra_mesh.h"
#include "tools/stress/stress_block_fixture.h"

namespace hpdm {

/// A cube with walls around a cavity: the hardest shape for a lattice.
struct HollowBody {
  OrganOptions organ;
  SurfaceMesh rest;
  std::vector<LoadOptions> loads;
  TetraMesh tetrahedra;  ///< Linear: one brick through the wall, ten bricks an edge.
};

/// Returns a box with edges of `edge` m, walls of `wall` m and a lattice of `cells` per axis. The
/// lowest tenth is held. A load of radius 15 mm presses the middle of the top.
HollowBody HollowBox(double edge, double wall, int cells);

/// Solves with the box's own tetrahedra, linear or quadratic.
StressAnswer TetraRest(const HollowBody& body, bool quadratic);

}  // namespace hpdm
