#pragma once

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// Returns the splines one degree lower than the lattice's along every axis, over the same box and
/// cells, split by tissue if the lattice's are. All control points of the coarsest level are kept. On
/// a finer level these are the splines of which at least half of the eight parents are in use, the
/// functions whose derivatives contain them: with fewer splines the refined tissue locks.
Lattice LowerDegree(const Lattice& lattice);

/// An orthonormal basis of the splines of LowerDegree() in the inner product (f, g) = int f g dV
/// over the tissue. Fields that the lattice cannot follow point by point are projected on it: the
/// dilatation (below) and fixed supports (support.h). Set-up only.
class CoarserSplines {
 public:
  /// Functions without tissue are left out. The squares (f, f) are raised by 1e-8, because slivers
  /// of tissue leave functions nearly dependent.
  CoarserSplines(const Lattice& lattice, const Quadrature& tissue);

  /// Returns P (m x k) such that |P c|^2 = int (projection of fields c)^2 dV. `fields` (Q x k):
  /// values of k fields at the tissue's points.
  Eigen::MatrixXd Project(const WeightMatrix& fields) const;

  /// Returns int psi_b field_k dV (m x k): Project(fields) = factor()^-1 Moments(fields).
  WeightMatrix Moments(const WeightMatrix& fields) const;
  /// Returns w_q psi_b(x_q), Q x m.
  const WeightMatrix& weighted_values() const { return weighted_values_; }
  /// Returns the lower Cholesky factor (m x m) of int psi psi^T dV.
  const Eigen::MatrixXd& factor() const { return factor_; }

 private:
  WeightMatrix weighted_values_;
  Eigen::MatrixXd factor_;
};

/// Returns P (m x 3n) such that |P u|^2 = int (projection of div u)^2 dV over the tissue. Unknown
/// 3 a + d of u is the displacement of control point a along world axis d.
///
/// The volumetric energy is lambda/2 |P u|^2 instead of lambda/2 int (div u)^2 dV. So nearly
/// incompressible tissue keeps its volume only as finely as the lattice can bend. This is the B-bar
/// method for splines (Elguedj, Bazilevs, Calo, Hughes 2008), equal to the mixed form with a
/// pressure in those splines.
Eigen::MatrixXd ProjectedDilatation(const Lattice& lattice, const Quadrature& tissue);

}  // namespace hpdm
