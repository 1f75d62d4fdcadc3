#pragma once

#include "engine/base/types.h"
#include "engine/energy/strain_energy.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Rows and columns are the entries of a 3 x 3 matrix, column by column: F_ij at 3 j + i.
using Matrix9d = Eigen::Matrix<double, 9, 9>;

/// Coefficients of the Neo-Hookean W_0 in units of mu:
/// W_0 = m/2 (I_C - 3 - log(I_C + 1)) + l_0/2 (J - alpha_0)^2 - (the same at rest).
struct NeoHookean {
  static constexpr double kM = 4.0 / 3, kL0 = 5.0 / 6, kAlpha0 = 11.0 / 5;
};

/// An isotropic hyperelastic material at one point: the energy per rest volume W(F) (Pa) of the
/// deformation gradient F = I + grad u.
///
/// 1. W is zero and stress-free at every rotation. Its Hessian at rest is that of small-strain
///    elasticity with the same Young's modulus and Poisson's ratio.
/// 2. W splits into
///        W = W_0(F) + lambda/2 theta(F)^2
///    with theta a measure of dilatation, tr(grad u) in small strain, and W_0 the same law with
///    lambda = 0.
/// 3. St. Venant-Kirchhoff, with the Green strain E = (F^T F - I) / 2 and theta = tr E:
///        W = mu |E|^2 + lambda/2 (tr E)^2.
///    It softens under compression. Below a stretch of 1/sqrt(3) = 0.577 its resistance falls, and
///    the tissue inverts.
/// 4. Stable Neo-Hookean (Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", 2018, Eq.
///    14), with I_C = |F|^2, J = det F and alpha = 1 + 3 m / (4 l):
///        W = m/2 (I_C - 3) + l/2 (J - alpha)^2 - m/2 log(I_C + 1) - W(I)
///        m = 4/3 mu,   l = lambda + 5/6 mu.
///    Completing the square in J gives theta = J - 1 and, in W_0, 5 mu/12 (J - 11/5)^2 for
///    l/2 (J - alpha)^2. The law is defined for every F and restores inverted tissue, also with
///    lambda = 0.
///
/// Plain functions of F; no allocation.
class HyperelasticLaw {
 public:
  HyperelasticLaw(MaterialLaw law, const LameParameters& lame);

  /// Returns W, Pa.
  double Energy(const Matrix3d& F) const;
  /// Returns the first Piola-Kirchhoff stress P = dW/dF, Pa.
  Matrix3d Stress(const Matrix3d& F) const;
  /// Returns dP/dF, Pa: symmetric, indefinite in strong compression.
  Matrix9d Tangent(const Matrix3d& F) const;

  /// True if the tissue is inverted or, for St. Venant-Kirchhoff, a principal stretch is below
  /// 1/sqrt(3).
  bool Collapsed(const Matrix3d& F) const;

  /// Returns theta. FiniteStrainEnergy averages theta over a neighbourhood and adds its energy to
  /// that of a law with a smaller lambda.
  double Dilatation(const Matrix3d& F) const;
  /// Returns d theta / dF.
  Matrix3d DilatationGradient(const Matrix3d& F) const;
  /// Adds pressure times d^2 theta / dF^2 to A.
  void AddDilatationHessian(const Matrix3d& F, double pressure, Matrix9d* A) const;

 private:
  double Pressure(double theta) const;
  Matrix9d NeoHookeanTangent(const Matrix3d& F) const;
  Matrix9d StVenantKirchhoffTangent(const Matrix3d& F) const;

  MaterialLaw law_;
  double mu_;      // Pa
  double lambda_;  // Pa
};

/// Returns the nearest positive semi-definite matrix: negative eigenvalues become zero.
Matrix9d ProjectedToSemiDefinite(const Matrix9d& tangent);

}  // namespace hpdm
