#pragma once

#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/hyperelastic.h"
#include "engine/energy/metric_energy.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The lattice's elastic energy for strain of any size, with its supports:
///     E(U) = int W_0(I + grad u) dV + lambda/2 int theta^2 dV + 1/2 sum_d U_d^T K_s U_d
/// over the organ's own tissue, with u = sum_a phi_a U_a and W_0 + lambda/2 theta^2 a
/// HyperelasticLaw.
///
/// Dilatation::kProjected replaces theta by its projection on splines one degree lower
/// (mixed_dilatation.h), so nearly incompressible tissue does not lock. A part of lambda stays
/// pointwise (ShareLambda); with W_0 it resists inversion at each point. The limit of small strain
/// is StrainStiffness with the same `dilatation`.
class FiniteStrainEnergy final : public ElasticEnergy {
 public:
  /// `tissue`: world, m, m^3. `supports`: K_s (n x n, N/m), the same along each axis.
  FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue, MaterialLaw law,
                     const LameParameters& lame, Dilatation dilatation,
                     const ScalarStiffness& supports);

  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<FiniteStrainEnergy>(*this);
  }
  int control_points() const override { return n_; }
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override;

 private:
  // Points of one lattice cell: the same functions are non-zero at all of them.
  struct Cell {
    std::vector<int> columns;   // m control points
    Eigen::MatrixXd gradients;  // 3q x m: rows 3 i + d hold d phi / d x_d at point i
    Eigen::VectorXd weights;    // q, m^3
    std::vector<int> coarser;   // c functions of the coarser splines; empty without projection
    Eigen::MatrixXd moments;    // q x c: w psi
  };

  void AddCell(const std::array<WeightMatrix, 3>& gradients, const WeightMatrix& moments,
               const Eigen::VectorXd& weights, Eigen::Index begin, Eigen::Index end);
  void GatherDeformation(const Cell& cell, const Points& U);
  Matrix3d DeformationAt(Eigen::Index q) const {
    return Matrix3d::Identity() + deformation_.middleRows<3>(3 * q).transpose();
  }
  double Project(const Points& U);
  double PressureAt(const Cell& cell, Eigen::Index q) const;
  void AddDilatationStiffness(const Points& U, FullStiffness* K);

  int n_;
  HyperelasticLaw law_;  // W with the pointwise part of lambda
  double lambda_;        // Pa: the projected part of lambda; 0 without projection
  ScalarStiffness supports_;
  FullStiffness support_stiffness_;  // 3n x 3n: K_s along each axis
  std::vector<Cell> cells_;
  Eigen::MatrixXd factor_;  // c x c, lower: CoarserSplines::factor()

  Eigen::VectorXd pressure_;     // c: lambda times the coefficients of the projected theta
  Eigen::MatrixXd dilatations_;  // c x 3n: its derivatives by U, as coefficients of L^-1
  Eigen::MatrixXd local_;        // m x 3: U or forces of a cell's functions
  Eigen::MatrixXd deformation_;  // 3q x 3: (grad u)^T at each point
  Eigen::MatrixXd stress_;       // 3q x 3: w P^T
  std::vector<Matrix9d> tangents_;
  Eigen::MatrixXd product_;  // 3q x m
  Eigen::MatrixXd block_;    // m x m
};

}  // namespace hpdm
