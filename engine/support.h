#pragma once

#include <vector>

#include "engine/lattice.h"
#include "engine/metric_energy.h"
#include "engine/organ_options.h"
#include "engine/surface_mesh.h"

namespace hpdm {

/// True when the world point (m) lies in the region; box fractions refer to `bounds`, the posed
/// organ's axis-aligned bounding box.
bool InRegion(const SupportOptions& support, const Box& bounds, const Vector3d& p_W);

/// Axis-aligned bounding box of the vertices (V x 3, m).
Box AxisAlignedBounds(const Points& vertices);

/// Stiffness that a fixed region stands for, Pa/m^2: 1e4 modulus / length^2, a penalty that holds
/// the tissue to 1e-4 of the organ's own displacement without locking the cells that straddle the
/// region's edge as a stiffer one does. `modulus`: alpha or Young's modulus, Pa; `length`: mean
/// edge of the lattice's box, m.
double FixedSupportStiffness(double modulus, double length);

/// The springs of the supports, by tissue volume: S_ab = int k(x) phi_a phi_b dV (N/m, n x n).
/// With no support at all, all tissue is tied to rest with 1e-3 modulus / length^2, so that the
/// organ stays finite. `tissue_in_supports` returns how much tissue each support holds (m^3).
ScalarStiffness SupportStiffness(const Lattice& lattice, const Quadrature& tissue,
                                 const std::vector<SupportOptions>& supports, const Box& bounds,
                                 double modulus, std::vector<double>* tissue_in_supports);

}  // namespace hpdm
