#pragma once

#include <vector>

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"
#include "engine/organ/placement_loads.h"
#include "engine/organ_options.h"

namespace hpdm {

/// A lattice with finer levels where its loads need them.
struct LevelPlacement {
  Lattice lattice;
  /// Estimate of what all functions of the finer levels that are left out would change: the energy
  /// norm of the change over that of u, root mean square over the cases. From a few steps of
  /// conjugate gradients.
  double error = 0;
};

/// Adds functions of finer levels (Lattice::AddLevel) to `coarse` until it has
/// `organ.lattice.adaptive.functions`. The functions are chosen one by one for the loads of `cases`.
///
/// 1. u solves each case on the functions in use. A candidate b of a finer level would lower the
///    energy by about g_b = r_b^T K_bb^-1 r_b / 2 with the residual r_b = f_b - K_b u (3) and its own
///    stiffness K_bb (3 x 3): the hierarchical a posteriori estimate (Bank, Smith 1993).
/// 2. The candidates with the largest sums of g_b / E over the cases are added in rounds. A candidate
///    of the second finer level needs a parent in use, a function of the next coarser level
///    whose refinement contains it.
/// 3. A candidate that the functions in use nearly span is left out: one whose pivot in the factor of
///    K is below 1e-2 of its own stiffness.
/// 4. A candidate that reaches into a fixed support is left out: the support's projection holds what
///    the coarse functions can follow, and a finer function would slip through it.
///
/// `tissue`: elastic weights (stiffness_regions.h), must resolve the cells of the finest level.
/// `regions`: tissue of each support. Deterministic; set-up only. Throws InputError if the organ's
/// stiffness is not positive definite.
LevelPlacement PlaceLevels(const Lattice& coarse, const OrganOptions& organ,
                           const Quadrature& tissue, const std::vector<Quadrature>& regions,
                           const std::vector<PlacementCase>& cases);

}  // namespace hpdm
