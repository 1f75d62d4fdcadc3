#pragma once

#include "engine/base/types.h"
#include "engine/energy/strain_energy.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Rows and columns are the entries of a 3 x 3 matrix column by column: F_ij at 3 j + i.
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// An isotropic hyperelastic material at one point: energy per rest volume W(F) (Pa) of the
/// deformation gradient F = I + grad u, which is zero and stress-free at every rotation and has
/// the Hessian of small-strain elasticity with the same Young's modulus and Poisson's ratio. It is
/// W = W_0(F) + lambda/2 theta(F)^2, with theta a measure of dilatation that is tr(grad u) in small
/// strain and W_0 the same law with lambda = 0.
///
/// St. Venant-Kirchhoff, with the Green strain E = (F^T F - I) / 2 and theta = tr E:
///     W = mu |E|^2 + lambda/2 (tr E)^2.
/// Under compression it softens, from a stretch of 1/sqrt(3) = 0.577 on without resistance, and
/// then turns inside out.
///
/// Stable Neo-Hookean (Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", 2018, Eq. 14),
/// with I_C = |F|^2, J = det F and alpha = 1 + 3 m / (4 l):
///     W = m/2 (I_C - 3) + l/2 (J - alpha)^2 - m/2 log(I_C + 1) - W(I),
///     m = 4/3 mu,   l = lambda + 5/6 mu.
/// Completing the square in J gives theta = J - 1 and, for W_0, l/2 (J - alpha)^2 = 5 mu/12
/// (J - 11/5)^2. Defined for every F and pulls inverted tissue back, also without lambda.
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

  /// Inverted, or (St. Venant-Kirchhoff) a principal stretch below 1/sqrt(3).
  bool Collapsed(const Matrix3d& F) const;

  /// theta, and what it is made of: for a theta that is averaged over a neighbourhood
  /// (FiniteStrainEnergy), beside a law with lambda = 0.
  double Dilatation(const Matrix3d& F) const;
  Matrix3d DilatationGradient(const Matrix3d& F) const;  ///< d theta / dF.
  /// Adds pressure times d^2 theta / dF^2.
  void AddDilatationHessian(const Matrix3d& F, double pressure, Matrix9d* A) const;

 private:
  double Pressure(double theta) const;

  MaterialLaw law_;
  double mu_;      // Pa
  double lambda_;  // Pa
};

/// The nearest positive semi-definite matrix: negative eigenvalues become zero.
Matrix9d ProjectedToSemiDefinite(const Matrix9d& tangent);

}  // namespace hpdm
