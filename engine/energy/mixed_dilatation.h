#pragma once

#include "engine/base/quadrature.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The splines one degree lower than a lattice's along every axis, over the same box and cells; all
/// control points kept.
Lattice LowerDegree(const Lattice& lattice);

/// An orthonormal basis of the splines one degree lower than a lattice's along every axis, over the
/// same cells and in the inner product of the tissue: (f, g) = int f g dV. It tests fields that the
/// lattice cannot follow point by point: the projected dilatation below and the projected supports
/// (support.h). Set-up only.
class CoarserSplines {
 public:
  /// Functions without tissue are left out; nearly dependent ones (slivers of tissue) are damped by
  /// 1e-8 of their own square.
  CoarserSplines(const Lattice& lattice, const Quadrature& tissue);

  /// `fields` (Q x k): values of k fields at the tissue's points. Returns P (m x k) such that
  /// |P c|^2 = int (projection of fields c)^2 dV.
  Eigen::MatrixXd Project(const WeightMatrix& fields) const;

  /// int psi_b field_k dV (m x k) of such fields, and the inner products int psi psi^T dV (m x m)
  /// as a lower Cholesky factor: Project(fields) = factor^-1 Moments(fields).
  WeightMatrix Moments(const WeightMatrix& fields) const;
  /// Q x m: w_q psi_b(x_q).
  const WeightMatrix& weighted_values() const { return weighted_values_; }
  const Eigen::MatrixXd& factor() const { return factor_; }

 private:
  WeightMatrix weighted_values_;  // Q x m: w_q psi_b(x_q)
  Eigen::MatrixXd factor_;        // m x m, lower: L with L L^T = int psi psi^T dV
};

/// P (m x 3n) such that |P u|^2 = int (projection of div u)^2 dV over the tissue, with unknown
/// 3 a + d the displacement of control point a along world axis d. A volumetric energy lambda/2
/// |P u|^2 instead of lambda/2 int (div u)^2 asks nearly incompressible tissue to keep its volume
/// only as finely as the lattice can bend: the B-bar method for splines (Elguedj, Bazilevs, Calo,
/// Hughes 2008), equal to the mixed form with a pressure in those splines.
Eigen::MatrixXd ProjectedDilatation(const Lattice& lattice, const Quadrature& tissue);

}  // namespace hpdm
