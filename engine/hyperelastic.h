#pragma once

#include "engine/organ_options.h"
#include "engine/strain_energy.h"
#include "engine/types.h"

namespace hpdm {

/// Rows and columns are the entries of a 3 x 3 matrix column by column: F_ij at 3 j + i.
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// An isotropic hyperelastic material at one point: energy per rest volume W(F) (Pa) of the
/// deformation gradient F = I + grad u, which is zero and stress-free at every rotation and has
/// the Hessian of small-strain elasticity with the same Young's modulus and Poisson's ratio.
///
/// St. Venant-Kirchhoff, with the Green strain E = (F^T F - I) / 2:
///     W = mu |E|^2 + lambda/2 (tr E)^2.
/// It softens under compression and lets tissue turn inside out.
///
/// Stable Neo-Hookean (Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", 2018, Eq. 14),
/// with I_C = |F|^2, J = det F and alpha = 1 + 3 m / (4 l):
///     W = m/2 (I_C - 3) + l/2 (J - alpha)^2 - m/2 log(I_C + 1) - W(I),
///     m = 4/3 mu,   l = lambda + 5/6 mu.
/// Defined for every F and pulls inverted tissue back.
///
/// Plain functions of F; no allocation.
class HyperelasticLaw {
 public:
  HyperelasticLaw(MaterialLaw law, const LameParameters& lame);

  double Energy(const Matrix3d& F) const;
  /// First Piola-Kirchhoff stress P = dW/dF, Pa.
  Matrix3d Stress(const Matrix3d& F) const;
  /// dP/dF, Pa, symmetric; indefinite in strong compression.
  Matrix9d Tangent(const Matrix3d& F) const;

 private:
  MaterialLaw law_;
  double m_;      // Pa: mu, or the Neo-Hookean's 4/3 mu
  double l_;      // Pa
  double alpha_;  // Neo-Hookean
  double rest_;   // Pa: its energy at rest before the shift to zero
};

/// The nearest positive semi-definite matrix: negative eigenvalues become zero.
Matrix9d ProjectedToSemiDefinite(const Matrix9d& tangent);

}  // namespace hpdm
