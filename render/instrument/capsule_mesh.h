#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// Returns an instrument's collision shape as a closed mesh in the tool frame T (m): a sphere of
/// `tip_radius` about the origin, continued by a shaft of `shaft_radius` along +z up to z =
/// `length`. A shaft thicker than the tip widens from the sphere's equator. `segments` (at least
/// 8) is the number of vertices around the axis. Both radii must be positive and `length` longer
/// than three times the larger radius; anything else is a bug.
SurfaceMesh CapsuleMesh(double tip_radius, double shaft_radius, double length, int segments = 24);

}  // namespace hpdm
