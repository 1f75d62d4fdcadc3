#pragma once

#include <memory>
#include <optional>

#include "engine/organ.h"
#include "tools/shared/static_case.h"
#include "tools/shared/timing.h"

namespace hpdm {

/// A deformable model of a case's organ, held by the case's load patches and moved as in the
/// deformation loop. Every load is a grasp row whose weights are the load's kernel. Steps of
/// reposition, relax and relocate bring it to its displacement, so error and time are those of the
/// real-time path.
///
/// Works for every model that is a Relaxation. The part of a load that the lattice does not resolve
/// (half_space.h) is added to it. Local functions are those at the loads.
class StaticCaseModel {
 public:
  /// Builds a lattice (options.model hpdm) or a surface model on the vertices of `rest`, which must
  /// outlive it, under `loads` (forces and displacements). Throws InputError if the options cannot
  /// be built or a load touches no surface.
  StaticCaseModel(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                  const OrganOptions& options);
  /// Builds a model of a case's surface and loads. `options` are the organ's, with the compared
  /// ones changed.
  StaticCaseModel(const StaticCase& load_case, const OrganOptions& options)
      : StaticCaseModel(load_case.rest, load_case.scene.loads, options) {}
  StaticCaseModel(const StaticCaseModel&) = delete;  // the relaxation refers to the organ
  StaticCaseModel& operator=(const StaticCaseModel&) = delete;

  /// Number of control points or vertices; local functions in use.
  int unknowns() const { return static_cast<int>(weights_.cols()); }
  int local_functions() const;
  double setup_ms() const { return setup_ms_; }  ///< Organ, weights and factors.
  const std::optional<OrganModel>& lattice_organ() const { return organ_; }

  /// Brings the body to rest under the case's loads. A force is met through the displacement of its
  /// patch, by Newton's method over the few patches with Broyden's update. Returns false if it is
  /// not met to 1e-4 of the loads.
  bool Balance();

  /// Moves the patches to their displacements in a solution `u` (V x 3, m), whatever the force.
  void MoveTo(const Points& u);

  /// Replaces the loads (at most as many as it was built for) and returns to the unloaded rest
  /// state.
  void Reload(const std::vector<LoadOptions>& loads);

  /// Copies the state of another body with the same unknowns.
  void StartFrom(const StaticCaseModel& other);

  /// Times repeated real-time steps between 0.95 of the loads' displacements and all of them.
  /// `response` repositions and relaxes. `relocation` moves the vertices with the lattice,
  /// `indentations` with the parts added at the loads. Ends at rest under the full loads.
  struct StepTimes {
    Timing response, relocation, indentations;
    RelaxationResult last;  ///< Result of one step, not of the repeats.
  };
  StepTimes TimeSteps();

  /// Times the steps of a way from rest to the loads' displacements, all of the same length, with
  /// nothing known of an earlier way. Loads are displacements. Ends at rest, as it was built.
  struct WayTimes {
    double mean_ms = 0, most_ms = 0;  ///< Of the thread; reposition and relax.
    double iterations = 0;            ///< Mean.
    int unfinished = 0;               ///< Steps that did not converge.
  };
  WayTimes TimeWay(int steps);

  /// V x 3, m.
  Points VertexDisplacements() const;
  /// Returns the first load's compliance, m/N; 0 without force.
  double Compliance() const;

 private:
  void AddPatches();
  void AddLatticeRow(std::size_t load);
  RelaxationResult Step(const Eigen::VectorXd& displacements);
  void Settle(const Eigen::VectorXd& displacements);
  Eigen::VectorXd Forces() const;
  bool IsDepth(Eigen::Index component) const;  // one of the loads' 3 m, given as displacement
  void AddIndentations(Points* vertices) const;

  const SurfaceMesh& rest_;
  std::vector<LoadOptions> loads_;
  OrganOptions options_;
  std::optional<OrganModel> organ_;
  WeightMatrix weights_;  // V x n: the lattice's weights, or the identity
  std::unique_ptr<Relaxation> relaxation_;
  int slots_ = 0;  // for local functions
  double setup_ms_ = 0;
  ContactConstraints contacts_;
  Points U_;                     // (n + slots) x 3, m
  std::optional<Points> start_;  // where the next relaxation starts; absent: where the last ended
  std::vector<LocalIndentation> indentations_;  // one per load; empty for the surface models
  Points vertices_;                             // V x 3, m
  ContactWeights patches_;                      // loads x V: the loads' kernels
  Eigen::VectorXd moved_;  // 3 x loads, m: patch displacements, without indentations
};

}  // namespace hpdm
