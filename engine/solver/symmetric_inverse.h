#pragma once

#include <Eigen/Core>

namespace hpdm {

/// Inverts a symmetric positive definite matrix in place (N x N; reads the lower triangle). Returns
/// the reciprocal condition number in the 1-norm. Returns 0 and leaves A undefined if A is not
/// positive definite.
///
/// The method is the symmetric sweep, a block of pivots at a time (Goodnight 1979, "A tutorial on
/// the sweep operator", Am. Stat. 33). It takes N^3/2 multiply-adds and a panel of memory; a
/// factorisation with N solves takes 7/6 N^3 and two more matrices. Set-up only; allocates the
/// panel.
double InvertSymmetric(Eigen::MatrixXd* A);

}  // namespace hpdm
