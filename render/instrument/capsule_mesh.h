#pragma once

#include "engine/mesh/surface_mesh.h"

namespace hpdm {

/// The shape an instrument collides with, as a closed mesh in the tool frame T (m): a sphere of
/// `tip_radius` about the origin, continued by a shaft of `shaft_radius` along +z up to z =
/// `length`. A shaft thicker than the tip widens from the sphere's equator on. `segments` around
/// the axis (at least 8). Both radii and `length` must be positive, `length` longer than three
/// times the larger radius; anything else is a bug.
SurfaceMesh CapsuleMesh(double tip_radius, double shaft_radius, double length, int segments = 24);

}  // namespace hpdm
