#pragma once

#include "engine/base/types.h"
#include "engine/organ_options.h"

namespace hpdm {

/// 9 x 9: row and column i + 3 j stand for the component (i, j) of a 3 x 3 matrix.
using Matrix9d = Eigen::Matrix<double, 9, 9>;

enum class TetraLaw { kSmallStrain, kNeoHookean };

/// Energy density of the reference solution's elements as a function of the deformation gradient F.
///
/// kSmallStrain: W = mu |e|^2 + lambda/2 tr(e)^2, e = (F + F^T)/2 - I.
/// kNeoHookean (Smith, de Goes, Kim, "Stable Neo-Hookean Flesh Simulation", 2018, Eq. 14):
///   W = m/2 (|F|^2 - 3) + l/2 (J - a)^2 - m/2 log(|F|^2 + 1), J = det F, a = 1 + 3 m / (4 l),
/// with m = 4/3 mu and l = lambda + 5/6 mu. So it agrees with mu and lambda at small strain
/// (section 3.4). It is finite and smooth for every F, inverted ones included.
class TetraMaterial {
 public:
  /// Takes Young's modulus (Pa) and Poisson's ratio.
  TetraMaterial(const MaterialOptions& material, TetraLaw law);

  TetraLaw law() const { return law_; }
  double Density(const Matrix3d& F) const;   ///< W, J/m^3; 0 at F = I up to a constant.
  Matrix3d Stress(const Matrix3d& F) const;  ///< dW/dF, first Piola-Kirchhoff, Pa.
  /// d2W/dF2, Pa. `convex` sets the negative eigenvalues to zero, so that a Newton step descends.
  Matrix9d Tangent(const Matrix3d& F, bool convex) const;

 private:
  TetraLaw law_;
  double mu_;      // Pa; m for kNeoHookean
  double lambda_;  // Pa; l for kNeoHookean
  double rest_;    // a
};

}  // namespace hpdm
