#pragma once

#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/metric_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/mesh/surface_mesh.h"
#include "engine/organ_options.h"

namespace hpdm {

/// True when the world point (m) lies in the region; box fractions refer to `bounds`, the posed
/// organ's axis-aligned bounding box.
bool InRegion(const Region& region, const Box& bounds, const Vector3d& p_W);

/// Axis-aligned bounding box of the vertices (V x 3, m).
Box AxisAlignedBounds(const Points& vertices);

/// The axis-aligned box of the region's part of the organ with the box `bounds`; empty (max < min)
/// when there is none.
Box BoundsOf(const Region& region, const Box& bounds);

/// The tissue of `rest_W` inside a support's region (world, m, m^3), sampled by cells of the
/// region's own of at most `spacing` (m), so that its edge is sharp wherever the lattice's cells
/// lie. Empty when it holds none. Set-up only.
Quadrature SampleSupport(const SurfaceMesh& rest_W, const SupportOptions& support,
                         const Box& bounds, double spacing);

/// Mean distance of neighbouring control points, m: h.
double ControlPointSpacing(const Lattice& lattice);

/// The springs of the supports (n x n, N/m, the same along each axis). regions[s] holds the tissue
/// of supports[s]; `tissue` is the organ's. Where it is stiffer or softer than `modulus`, its
/// weights, and those of a fixed support's tissue, are multiplied alike (ElasticWeights).
///
/// A support with a stiffness k(x) has the energy 1/2 int k |u|^2 dV. A fixed one has 1/2 int k
/// |Pu|^2 dV with k = 256 modulus / h^2 and P the projection on splines one degree lower over the
/// region (mixed_dilatation.h): it holds what these can see and leaves the cells that straddle the
/// region's edge free to bend, which a penalty on u itself locks. A bar of 6 x 2 x 2 cells whose
/// support ends anywhere in a cell then has 0.98-1.01 of its exact compliance in tension (0.93-1.02
/// in bending), and 4 or 400 times that stiffness changes the mean by 2 % (6 %); with P = 1 it has
/// 0.94-1.00 (0.84-0.96) and falls to 0.79 (0.50) as k rises.
///
/// With no support at all, all tissue is tied to rest with 1e-3 modulus / length^2 (length: mean
/// edge of the lattice's box), so that the organ stays finite. `modulus`: alpha or Young's, Pa.
///
/// The two stiffnesses, Pa/m^2, of which a lattice with h and this box makes its springs:
double FixedSupport(const Lattice& lattice, double modulus);
double WeakSupport(const Lattice& lattice, double modulus);
ScalarStiffness SupportStiffness(const Lattice& lattice, const Quadrature& tissue,
                                 const std::vector<SupportOptions>& supports,
                                 const std::vector<Quadrature>& regions, double modulus);

}  // namespace hpdm
