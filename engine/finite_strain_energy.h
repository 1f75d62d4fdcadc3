#pragma once

#include <vector>

#include "engine/hyperelastic.h"
#include "engine/lattice.h"
#include "engine/metric_energy.h"
#include "engine/quadrature.h"

namespace hpdm {

/// The lattice's elastic energy for strain of any size, with its supports:
///     E(U) = int W(I + grad u) dV + 1/2 sum_d U_d^T S U_d,
/// over the organ's own tissue, u = sum_a phi_a U_a, W a HyperelasticLaw. Constant once built; its
/// methods keep scratch space, so one thread uses one object.
class FiniteStrainEnergy {
 public:
  /// `tissue`: world, m, m^3. `supports` (n x n, N/m): S, alike along each axis.
  FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue, const HyperelasticLaw& law,
                     const ScalarStiffness& supports);

  int control_points() const { return n_; }

  /// J, under control displacements U (n x 3, m).
  double Energy(const Points& U);
  /// The same, and dE/dU (n x 3, N).
  double Gradient(const Points& U, Points* gradient);
  /// d^2E/dU^2 (3n x 3n, N/m). With `semi_definite`, each point's tangent is projected first, so
  /// that the sum is positive semi-definite and still exact where W is convex.
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K);

 private:
  // The points of one lattice cell, on which the same functions are not zero.
  struct Cell {
    std::vector<int> columns;   // m control points
    Eigen::MatrixXd gradients;  // 3q x m: rows 3 i + d hold d phi / d x_d at point i
    Eigen::VectorXd weights;    // q, m^3
  };

  void GatherDeformation(const Cell& cell, const Points& U);
  Matrix3d DeformationAt(Eigen::Index q) const {
    return Matrix3d::Identity() + deformation_.middleRows<3>(3 * q).transpose();
  }

  int n_;
  HyperelasticLaw law_;
  ScalarStiffness supports_;
  FullStiffness support_stiffness_;  // 3n x 3n: S along each axis
  std::vector<Cell> cells_;

  Eigen::MatrixXd local_;        // m x 3: U or forces of a cell's functions
  Eigen::MatrixXd deformation_;  // 3q x 3: (grad u)^T at each point
  Eigen::MatrixXd stress_;       // 3q x 3: w P^T
  std::vector<Matrix9d> tangents_;
  Eigen::MatrixXd product_;  // 3q x m
  Eigen::MatrixXd block_;    // m x m
};

}  // namespace hpdm
