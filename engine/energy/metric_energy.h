#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// n x n, N/m: the same for the control displacements along x, y and z.
using ScalarStiffness = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// Returns the stiffness K of the paper's lattice energy (Eq. 14-22 for a solid, linear part;
/// engine/README.md, section 5):
///     E(U) = 1/2 sum_k int alpha |d_k U|^2 + beta |d_kk U|^2 dV = 1/2 U^T K U.
///
/// 1. Derivatives are differences of neighbouring control points at the spacing
///    h_k = box length / cells (Bernstein: / degree).
/// 2. In the derivative of the lattice map, a function of one degree lower along k multiplies each
///    difference along k. The tissue under that function is the difference's weight. So the weights
///    of one direction add up to the tissue's volume.
/// 3. A second difference has the mean weight of its two differences.
/// 4. E is a sum of squared differences, so K is symmetric, positive semi-definite and has zero row
///    sums. The stencil printed as Eq. 19 is not (engine/README.md, section 3).
///
/// `tissue`: points over the organ, or over the whole box (BoxQuadrature). `alpha`: Pa; `beta`: N.
ScalarStiffness MetricStiffness(const Lattice& lattice, const Quadrature& tissue, double alpha,
                                double beta);

/// Grid indices (i, j, k) of a control point.
using GridPoint = std::array<int, 3>;

/// Neighbouring control points and the tissue that weights their difference.
struct DifferenceGroup {
  GridPoint at;  ///< The one of least indices.
  std::array<int, 4>
      columns;        ///< Columns (or -1) of the two along one axis, or of the corners 00, 01,
                      ///< 10, 11 along two.
  double weight = 0;  ///< m^3, > 0.
};

/// Integrates over the tissue the tensor functions with the degree reduced by one along each of
/// `axes` (one or two), which multiply the lattice's differences along those axes. Returns each group
/// of neighbours with tissue, in the order of the grid. Where functions are split, the groups of one
/// place differ in their columns.
std::vector<DifferenceGroup> DifferenceWeights(const Lattice& lattice, const Quadrature& tissue,
                                               const std::vector<int>& axes);

/// Returns the midpoints of per_axis[0] x per_axis[1] x per_axis[2] equal cells. World, m, m^3.
Quadrature BoxQuadrature(const OrientedBox& box, const std::array<int, 3>& per_axis);

}  // namespace hpdm
