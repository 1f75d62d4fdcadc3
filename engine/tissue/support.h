#pragma once

#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/metric_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// True if the world point (m) lies in the region. Box fractions refer to `bounds`, the posed
/// organ's axis-aligned bounding box.
bool InRegion(const Region& region, const Box& bounds, const Vector3d& p_W);

/// Returns the axis-aligned bounding box of the vertices (V x 3, m).
Box AxisAlignedBounds(const Points& vertices);

/// Returns the axis-aligned box of the region's part inside the organ's box `bounds`; empty
/// (max < min) if there is none.
Box BoundsOf(const Region& region, const Box& bounds);

/// Samples the tissue of `rest_W` inside a support's region (world, m, m^3). The region has its own
/// cells of at most `spacing` (m), so its edge is sharp wherever the lattice's cells lie. Empty if
/// the region contains no tissue. Set-up only.
Quadrature SampleSupport(const SurfaceMesh& rest_W, const SupportOptions& support,
                         const Box& bounds, double spacing);

/// Returns the mean distance h of neighbouring control points, m.
double ControlPointSpacing(const Lattice& lattice);

/// Returns the spring density of a fixed support, 256 modulus / h^2, Pa/m^2. `modulus`: alpha or
/// Young's modulus, Pa.
double FixedSupport(const Lattice& lattice, double modulus);

/// Returns the spring density (Pa/m^2) that ties an organ without supports to its rest shape. It is
/// 1e-3 modulus / length^2 with the mean edge length of the lattice's box.
double WeakSupport(const Lattice& lattice, double modulus);

/// Returns the springs of the supports (n x n, N/m, the same along each axis). The element
/// regions[s] is the tissue of supports[s], and `tissue` is that of the organ. The weights of
/// tissue stiffer or softer than `modulus` (Pa), and those of a fixed support's region, must be
/// scaled alike (ElasticWeights).
///
/// 1. A support with a stiffness k has the energy 1/2 int k |u|^2 dV.
/// 2. A fixed support has the energy 1/2 int k |P u|^2 dV with k = FixedSupport(). P is the
///    projection on splines one degree lower over the region (mixed_dilatation.h). It leaves the
///    cells that straddle the region's edge free to bend; a penalty on u itself locks them.
/// 3. Without supports, all tissue is tied to rest with WeakSupport(), so the organ stays in place.
///
/// Compliance over the exact one of a bar of 6 x 2 x 2 cells whose support ends anywhere in a cell:
///     with P:   0.98-1.01 in tension, 0.93-1.02 in bending; 4 or 400 times k changes the mean by
///               2 % in tension, 6 % in bending
///     P = 1:    0.94-1.00 in tension, 0.84-0.96 in bending; falls to 0.79 and 0.50 as k rises
ScalarStiffness SupportStiffness(const Lattice& lattice, const Quadrature& tissue,
                                 const std::vector<SupportOptions>& supports,
                                 const std::vector<Quadrature>& regions, double modulus);

}  // namespace hpdm
