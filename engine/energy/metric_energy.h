#pragma once

#include <Eigen/SparseCore>
#include <array>
#include <utility>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// n x n, N/m: couples the control displacements in x, y and z alike.
using ScalarStiffness = Eigen::SparseMatrix<double, Eigen::RowMajor>;

/// The paper's lattice energy (Eq. 14-22 for a solid, linear part; engine/README.md, section 5):
///     E(U) = 1/2 sum_k int alpha |d_k U|^2 + beta |d_kk U|^2 dV = 1/2 U^T K U
/// by differences of neighbouring control points at spacing h_k = box length / cells (Bernstein:
/// / degree). A difference along k is weighted by the tissue under the function that multiplies it
/// in the derivative of the lattice map (degree reduced by one along k), so the weights of one
/// direction add up to the tissue's volume; a second difference has the mean weight of its two
/// differences. Being a sum of squares of differences, K is symmetric, positive semi-definite and
/// has zero row sums, which the stencil printed as Eq. 19 lacks (engine/README.md, section 3).
/// `tissue`: points over the organ, or over the whole box (BoxQuadrature). alpha in Pa, beta in N.
ScalarStiffness MetricStiffness(const Lattice& lattice, const Quadrature& tissue, double alpha,
                                double beta);

/// Grid indices (i, j, k) of a control point.
using GridPoint = std::array<int, 3>;

/// Integral over the tissue of the tensor functions with the degree reduced by one along each of
/// `axes`, which multiply the lattice's differences there: for each group of neighbours along those
/// axes with tissue, the grid point of least indices and the integral, m^3, > 0.
std::vector<std::pair<GridPoint, double>> DifferenceWeights(const Lattice& lattice,
                                                            const Quadrature& tissue,
                                                            const std::vector<int>& axes);

/// The midpoints of per_axis[0] x per_axis[1] x per_axis[2] equal cells. World, m, m^3.
Quadrature BoxQuadrature(const OrientedBox& box, const std::array<int, 3>& per_axis);

}  // namespace hpdm
