#pragma once

#include <memory>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/elastic_energy.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_kernels.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// The lattice's elastic energy for strain of any size, with its supports and with local functions
/// as further unknowns V (slots x 3, after U's rows):
///     E(U, V) = int W_0(F) dV + lambda/2 int theta^2 dV + 1/2 sum_d U_d^T K_s U_d,
///     F = I + grad u,   u = sum_a phi_a U_a + sum_s psi_s V_s
/// over the organ's own tissue, with W_0 + lambda/2 theta^2 a HyperelasticLaw.
///
/// Dilatation::kProjected replaces theta by its projection P theta on splines one degree lower
/// (mixed_dilatation.h), so nearly incompressible tissue does not lock. A part of lambda stays
/// pointwise (ShareLambda); with W_0 it resists inversion at each point. What the local functions
/// add to theta, theta_V = theta(F) - theta(I + grad sum_a phi_a U_a), counts point by point: the
/// energy gets lambda/2 (int theta_V^2 dV - int (P theta_V)^2 dV). The limit of small strain is
/// StrainStiffness with the same `dilatation`, with local functions the energy of RefinementBasis.
///
/// A function of weight w (active_refinement.h) has the further energy (1/w - 1)/2 k |V|^2, with k a
/// third of the trace of its own block, so it fades.
class FiniteStrainEnergy final : public ElasticEnergy {
 public:
  /// `tissue`: world, m, m^3; with `finer`, over its cells. `supports`: K_s (n x n, N/m), the same
  /// along each axis. `finer`: the local functions (RefinementBasis::finer), or nullptr.
  FiniteStrainEnergy(const Lattice& lattice, const Quadrature& tissue, MaterialLaw law,
                     const LameParameters& lame, Dilatation dilatation,
                     const ScalarStiffness& supports, const Lattice* finer = nullptr);

  std::unique_ptr<ElasticEnergy> Clone() const override {
    return std::make_unique<FiniteStrainEnergy>(*this);
  }
  void Take(const ElasticEnergy& other) override {
    *this = static_cast<const FiniteStrainEnergy&>(other);
  }
  int control_points() const override { return body_->n; }
  void SetActiveFunctions(const ActiveRefinement& active) override;
  double Energy(const Points& U) override;
  double Gradient(const Points& U, Points* gradient) override;
  void Hessian(const Points& U, bool semi_definite, FullStiffness* K) override;
  double CollapsedShare(const Points& U) override;
  Matrix3d MeanRotation(const Points& U) override;

  /// Uses the kernels of that width; for tests.
  void UseKernels(VectorWidth width) { kernels_ = &StrainKernelsFor(width); }

 private:
  // Points of one cell: the same functions are non-zero at all of them.
  struct Cell {
    std::vector<int> columns;    // control points
    std::vector<int> functions;  // local functions
    std::vector<int> coarser;    // functions of the coarser splines; empty without projection
    int first = 0, blocks = 0;   // of Lanes
    // Entries after each other: blocks x columns x 3, blocks x functions x 3, blocks x coarser.
    std::size_t gradients = 0, finer_gradients = 0, moments = 0;
  };
  // The constant part, shared by clones.
  struct Body {
    int n = 0;
    StrainLaw law;      // with the pointwise part of lambda
    double lambda = 0;  // Pa: the projected part of lambda; 0 without projection
    ScalarStiffness supports;
    FullStiffness support_stiffness;  // 3n x 3n: K_s along each axis
    std::vector<Cell> cells;
    std::vector<Lanes> weights;          // m^3; 0 in lanes without a point
    std::vector<Lanes> gradients;        // 1/m
    std::vector<Lanes> finer_gradients;  // 1/m
    std::vector<Lanes> moments;          // w psi, m^3
    Eigen::MatrixXd inverse_mass;        // c x c: of the coarser splines
    Points mean_gradients;               // n x 3: int grad phi_a dV over the volume, 1/m
    std::vector<double> own_stiffness;  // N/m, of each local function: a third of its block's trace
  };
  // The local functions in use in a cell: the first `count` entries of each. Sized for all.
  struct Refined {
    int count = 0;
    std::vector<int> places;  // in Cell::functions
    std::vector<int> slots;
    std::vector<Lanes> gradients;  // blocks x count x 3
  };

  static void AddCell(const std::array<WeightMatrix, 3>& gradients,
                      const std::array<WeightMatrix, 3>& finer_gradients,
                      const WeightMatrix& moments, const Eigen::VectorXd& weights,
                      Eigen::Index begin, Eigen::Index end, Body* body);
  static void AddMeans(const Cell& cell, Body* body);
  void Deform(const Points& U);
  void Project();
  void FillPressures(std::size_t cell);
  double AddStress(std::size_t cell, Points* gradient);
  struct CellFunctions;
  CellFunctions FunctionsOf(std::size_t cell) const;
  void AddTangent(std::size_t cell, bool semi_definite, FullStiffness* K);
  void AddDilatationStiffness(FullStiffness* K);
  bool IsRefined(std::size_t cell) const { return !refined_.empty() && refined_[cell].count > 0; }

  std::shared_ptr<const Body> body_;
  const StrainKernels* kernels_;
  std::vector<Refined> refined_;  // of each cell; empty without local functions
  std::vector<double> fading_;    // N/m: what keeps the function in each slot from moving
  // Of each block: F, d theta/dF and theta of all functions, and of the lattice alone.
  std::vector<Lanes> F_, slope_, theta_, lattice_F_, lattice_slope_, lattice_theta_;
  Eigen::VectorXd moment_, pressure_;          // c: int theta psi, and the projection times lambda
  Eigen::VectorXd own_moment_, own_pressure_;  // c: the same of theta_V
  std::vector<double> local_;                  // displacements or forces of a cell's functions
  std::vector<Lanes> stress_;
  std::vector<Lanes> pressures_, own_pressures_;  // of each point of a cell, times its weight
};

}  // namespace hpdm
