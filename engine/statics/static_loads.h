#pragma once

#include <optional>
#include <vector>

#include "engine/organ.h"
#include "engine/solver/compliance_solver.h"
#include "engine/solver/schur_complement.h"
#include "engine/solver/sparse_cholesky.h"

namespace hpdm {

/// Equilibrium of an organ under its loads.
struct StaticSolution {
  Points control_displacements;       ///< (n + local functions) x 3, m, world axes.
  Points vertex_displacements;        ///< V x 3, m.
  std::vector<Vector3d> load_forces;  ///< N, on the tissue, one per load.
  /// m, one per load: kernel-weighted mean of u, or the mean over a pressure's area.
  std::vector<Vector3d> load_displacements;
  std::vector<double> lumen_pressures;  ///< Pa, of each filled lumen, over that at rest.
  std::vector<double> layer_tensions;   ///< N/m, the largest of each layer (LayerTensions).
  double residual = 0;  ///< Finite strain: |dE/dU - R| / |R|; else see StaticLoads::Residual.
  double share = 1;     ///< Share of the loads that was reached: below 1 if Newton's method failed.
  double collapsed = 0;  ///< Share of the tissue where the law has failed (ElasticEnergy).
  int iterations = 0;    ///< Newton iterations; 0: one linear solve.

  /// Displacement of the first load along its force over the force, m/N; 0 without a resultant, as
  /// under pressure all around a body.
  double Compliance() const;
};

/// The static loads of one organ, acting together: given forces, given displacements whose forces
/// are found (both spread by SurfaceKernel), and pressures over the surface.
///
/// A constant stiffness (small displacement) is factorised once at set-up. Finite strain iterates
/// by Newton's method, and mass_spring iterates to rest. Solve may be called repeatedly.
class StaticLoads {
 public:
  /// `model` must outlive this. Throws InputError if a load touches no surface.
  StaticLoads(const OrganModel& model, const std::vector<LoadOptions>& loads);

  StaticSolution Solve() const;

  /// |K U - R| / |R| of a solution (finite strain: |dE/dU - R| / |R|), 0 without load.
  double Residual(const StaticSolution& solution) const;

  /// Number of local functions in use.
  int local_functions() const { return active_.used(); }

 private:
  void AddPressure(std::size_t load);
  void AddPatch(std::size_t load);
  void Respond(Eigen::MatrixXd* columns) const;
  Eigen::VectorXd Forces(const Eigen::MatrixXd& compliance, const Eigen::VectorXd& free) const;
  StaticSolution SolveFinite() const;
  void AddSurfaceState(StaticSolution* solution) const;
  void AddIndentations(const Eigen::VectorXd& forces, StaticSolution* solution) const;

  const OrganModel& model_;
  std::vector<LoadOptions> loads_;
  ActiveRefinement active_;
  std::vector<LocalIndentation> indentations_;       // one per load
  std::unique_ptr<ComplianceSolver> solver_;         // a lattice with constant stiffness
  std::optional<SchurComplement> schur_complement_;  // the local functions in use
  std::optional<SparseCholesky> surface_;            // the continuum
  // 3(n + slots) x 3m: column 3 i + d puts a unit force along d on load i's patch.
  Eigen::MatrixXd rows_;
  Eigen::VectorXd pressures_;             // 3(n + slots), N: generalised force of all pressures
  std::vector<Vector3d> pressure_force_;  // N, one per load: resultant of a pressure
};

}  // namespace hpdm
