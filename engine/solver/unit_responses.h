#pragma once

#include <Eigen/Core>
#include <span>

#include "engine/base/vector_width.h"
#include "engine/contact/lattice_compliance.h"

namespace hpdm {

/// Sets `responses` (3n x 3 rows, m/N) to K^-1 B^T, with K^-1 in `inverse` (3n x 3n): columns 3 i to 3 i + 2
/// are the displacements under a unit force along each axis on the point of row i. Entries of a row
/// beyond n do not count.
///
/// Neighbouring points have most control points in common, so the columns of K^-1 are read once for all
/// rows. Each entry is summed in the order of the control points, without fused operations, whatever
/// the vectors: results are equal bit for bit. Any thread; allocates nothing. `width`: another than the
/// widest, for tests.
void FillUnitResponses(const Eigen::MatrixXd& inverse, std::span<const SparseRow> rows,
                       Eigen::Ref<Eigen::MatrixXd> responses, VectorWidth width = WidestVectors());

}  // namespace hpdm
