#pragma once

#include <Eigen/Core>

namespace hpdm {

/// A -> A^-1 in place, of a symmetric positive definite matrix (N x N, of which the lower triangle
/// counts): the symmetric sweep (Goodnight 1979, "A tutorial on the sweep operator", Am. Stat. 33)
/// a block of pivots at a time, N^3/2 multiply-adds and a panel of memory, where a factorisation
/// and its N solves take 7/6 N^3 and two more matrices. Returns the reciprocal condition number in
/// the 1-norm, or 0, with A spoilt, when A is not positive definite.
///
/// Set-up only; allocates the panel.
double InvertSymmetric(Eigen::MatrixXd* A);

}  // namespace hpdm
