#pragma once

#include <optional>
#include <vector>

#include "engine/organ.h"
#include "engine/solver/compliance_solver.h"
#include "engine/solver/schur_complement.h"
#include "engine/solver/sparse_cholesky.h"

namespace hpdm {

/// Where an organ rests under its loads.
struct StaticSolution {
  Points control_displacements;       ///< (n + local functions) x 3, m, world axes.
  Points vertex_displacements;        ///< V x 3, m.
  std::vector<Vector3d> load_forces;  ///< N, on the tissue, one a load.
  /// m, one a load: u's mean weighted by the kernel, or over the area that a pressure acts on.
  std::vector<Vector3d> load_displacements;
  double residual = 0;  ///< Finite strain: |dE/dU - R| / |R|; else see StaticLoads::Residual.
  double share = 1;  ///< Of the loads that the organ carries: below 1 where Newton's method failed.
  double collapsed = 0;  ///< Share of the tissue where the law has failed (ElasticEnergy).
  int iterations = 0;    ///< Of Newton's method; 0: one linear solve.

  /// Of the first load: displacement along its force over the force, m/N; 0 without force,
  /// as of a pressure all around a body.
  double Compliance() const;
};

/// The loads of one organ: forces that are given, and displacements whose forces are found, all
/// acting together, each spread by the kernel of SurfaceKernel, and pressures over the surface.
/// Small displacement (constant stiffness): set-up factorises it once. Only mass_spring iterates,
/// to rest. Solve may be called again and again.
class StaticLoads {
 public:
  /// `model` must outlive this. Throws InputError when a load touches no surface.
  StaticLoads(const OrganModel& model, const std::vector<LoadOptions>& loads);

  StaticSolution Solve() const;

  /// |K U - R| / |R| of a solution (finite strain: |dE/dU - R| / |R|), 0 without load.
  double Residual(const StaticSolution& solution) const;

  /// Local functions in use.
  int local_functions() const { return active_.used(); }

 private:
  void AddPressure(std::size_t load);
  void AddPatch(std::size_t load);
  void Respond(Eigen::MatrixXd* columns) const;
  Eigen::VectorXd Forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free) const;
  StaticSolution SolveFinite() const;
  void AddIndentations(const Eigen::VectorXd& forces, StaticSolution* solution) const;

  const OrganModel& model_;
  std::vector<LoadOptions> loads_;
  ActiveRefinement active_;
  std::vector<LocalIndentation> indentations_;       // one a load
  std::unique_ptr<ComplianceSolver> solver_;         // of a lattice with constant stiffness
  std::optional<SchurComplement> schur_complement_;  // the local functions in use
  std::optional<SparseCholesky> surface_;            // of the continuum
  // 3(n + slots) x 3m: column 3 i + d puts a unit force along d on load i's patch.
  Eigen::MatrixXd rows_;
  Eigen::VectorXd pressures_;             // 3(n + slots), N: what all pressures put on U
  std::vector<Vector3d> pressure_force_;  // N, one a load: a pressure's resultant
};

}  // namespace hpdm
