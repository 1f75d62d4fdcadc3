#pragma once

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Reduces the points of `tissue` to fewer with the same moments up to `degree` (CompressMoments):
/// those of each group at which the same functions of `lattice`, and of `finer` unless it is nullptr,
/// are non-zero. Points of a group follow each other, cell by cell. With levels of functions, a group
/// lies in one cell of the finest level that has a function there. Set-up only.
Quadrature CompressedQuadrature(const Lattice& lattice, const Lattice* finer,
                                const Quadrature& tissue, int degree);

}  // namespace hpdm
