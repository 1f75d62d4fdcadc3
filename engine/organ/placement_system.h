#pragma once

#include <Eigen/Cholesky>
#include <array>
#include <vector>

#include "engine/base/quadrature.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"
#include "engine/organ/placement_loads.h"
#include "engine/organ_options.h"

namespace hpdm {

/// The functions of a finer level that have tissue, N in number, with what the placement needs of
/// them.
struct PlacementLevel {
  Lattice lattice;
  std::vector<bool> used;                         ///< N: in use.
  std::vector<bool> refused;                      ///< N: the functions in use nearly span it.
  std::array<WeightMatrix, 3> gradients;          ///< At the tissue's points, Q x N each, 1/m.
  std::vector<WeightMatrix> held;                 ///< At each support's points, Q x N.
  std::vector<std::vector<WeightMatrix>> loaded;  ///< At each case's loads' samples, S x N.
  std::vector<Matrix3d> own;                      ///< N: K_bb, N/m.
};

/// The displacements of the cases and what holds them, at the points of the tissue and supports.
struct PlacementSolution {
  Lattice lattice;
  Eigen::MatrixXd U;                      ///< 3n x cases, m.
  Eigen::VectorXd energies;               ///< Cases: twice the work of the loads, J.
  std::vector<PlacementCase> cases;       ///< All loads as forces.
  std::array<Eigen::MatrixXd, 3> stress;  ///< w sigma e_j at the tissue's points: Q x 3 cases, N m.
  std::vector<Eigen::MatrixXd> held;      ///< Forces at each support's points: Q x 3 cases, N.
};

/// The elastic problem of an organ's load cases, on the functions in use and against those that
/// could be. Its points are few: each cell of the finest level keeps the moments of low degree.
/// Set-up only.
class PlacementSystem {
 public:
  /// As PlaceLevels() (level_placement.h). All arguments must outlive this.
  PlacementSystem(const Lattice& coarse, const OrganOptions& organ, const Quadrature& tissue,
                  const std::vector<Quadrature>& regions, const std::vector<PlacementCase>& cases);

  /// Returns the finer levels, from coarse to fine, whose functions the caller takes into use.
  std::vector<PlacementLevel>* levels() { return &levels_; }

  /// Solves the cases. Functions in use that the others nearly span are refused and left out. Throws
  /// InputError if the stiffness is not positive definite.
  PlacementSolution Solve();
  /// Returns r_b = f_b - K_b u for each level: N x 3 cases, N. Columns 3 c to 3 c + 2 are those of a
  /// case.
  std::vector<Eigen::MatrixXd> Residuals(const PlacementSolution& solution) const;
  /// Returns LevelPlacement::error.
  double Error(const std::vector<Eigen::MatrixXd>& residuals,
               const PlacementSolution& solution) const;

 private:
  Lattice Level(int level) const;
  void Prepare(PlacementLevel* level);
  std::vector<Matrix3d> OwnStiffness(const PlacementLevel& level) const;
  double Spring(std::size_t support, const Lattice& lattice) const;
  Lattice Assemble() const;
  bool RefuseSpanned(const Lattice& lattice, const FullStiffness& K, const Eigen::MatrixXd& L);
  FullStiffness Stiffness(const Lattice& lattice) const;
  void SolveCase(const Eigen::LLT<Eigen::MatrixXd>& llt, Eigen::Index number,
                 PlacementSolution* solution);
  std::array<Eigen::MatrixXd, 3> Stress(const std::array<Eigen::MatrixXd, 3>& gradient,
                                        const Eigen::MatrixXd& projected) const;
  void MeasureStress(PlacementSolution* solution) const;
  Eigen::MatrixXd Residual(const PlacementLevel& level, const PlacementSolution& solution) const;

  const Lattice& coarse_;
  const OrganOptions& organ_;
  const std::vector<Quadrature>& regions_;
  const std::vector<PlacementCase>& cases_;
  Quadrature points_;
  std::vector<PlacementLevel> levels_;
};

}  // namespace hpdm
