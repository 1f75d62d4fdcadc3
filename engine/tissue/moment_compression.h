#pragma once

#include <Eigen/Core>

#include "engine/base/types.h"

namespace hpdm {

/// Number of monomials x^i y^j z^k with i, j, k <= degree and i + j + k <= 2 degree: 1, 7, 23, 54,
/// 105 for degree 0..4. The integrands, products of tensor splines' derivatives, have their high
/// degrees spread over the axes.
int MomentCount(int degree);

/// A positive quadrature rule on few points with the moments of one on many: chooses at most
/// MomentCount(degree) of the given points and new weights > 0 such that those polynomials keep
/// their integrals (to about 1e-12 relative). Such a choice exists by
/// Caratheodory's theorem; it is found by eliminating null vectors of the moments over ever smaller
/// groups of neighbouring points (Maalouf, Jubran, Feldman, "Fast and accurate least-mean-squares
/// solvers", 2019).
///
/// `degree` 0..6; `points` N x 3, best within [-1, 1]^3 and ordered so that neighbours lie
/// together; `weights` N, > 0. Both are replaced. Deterministic.
void CompressMoments(int degree, Points* points, Eigen::VectorXd* weights);

}  // namespace hpdm
