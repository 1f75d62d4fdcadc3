#pragma once

#include <Eigen/Core>

#include "engine/base/types.h"

namespace hpdm {

/// Returns the number of monomials x^i y^j z^k with i, j, k <= degree and i + j + k <= 2 degree. It
/// is 1, 7, 23, 54, 105 for degree 0..4. These monomials suit the integrands, products of
/// derivatives of tensor splines, whose degree is spread over the axes.
int MomentCount(int degree);

/// Reduces a positive quadrature rule to few points with the same moments. Chooses at most
/// MomentCount(degree) of the given points and new weights > 0 such that those polynomials keep
/// their integrals (to about 1e-12 relative).
///
/// The choice exists by Caratheodory's theorem. It is found by eliminating null vectors of the
/// moments over ever smaller groups of neighbouring points. Reference: Maalouf, Jubran, Feldman,
/// "Fast and accurate least-mean-squares solvers", 2019.
///
/// `degree`: 0..6; `points`: N x 3, best within [-1, 1]^3 and with neighbours close in the order;
/// `weights`: N, > 0. Both are replaced. Deterministic.
void CompressMoments(int degree, Points* points, Eigen::VectorXd* weights);

}  // namespace hpdm
