#pragma once

#include <memory>
#include <optional>

#include "engine/organ.h"
#include "tools/shared/static_case.h"
#include "tools/shared/timing.h"

namespace hpdm {

/// A deformable model of a case's organ, held by the case's load patches and moved as the
/// deformation loop moves it: every load is a grasp row with the load's kernel for weights, taken
/// to a displacement by steps of reposition, relax and relocate. So error and time are those of the
/// real-time path, for every model that is a Relaxation. What a lattice does not resolve of a load
/// (half_space.h) is added to it, and local functions are those at the loads.
class StaticCaseModel {
 public:
  /// A lattice (options.model hpdm) or a surface model of the vertices of `rest`, which must
  /// outlive it, under `loads`: forces and displacements. Throws InputError when the options cannot
  /// be built or a load touches no surface.
  StaticCaseModel(const SurfaceMesh& rest, const std::vector<LoadOptions>& loads,
                  const OrganOptions& options);
  /// Of a case's surface and loads; `options` are those of its organ with what is to be compared
  /// changed.
  StaticCaseModel(const StaticCase& load_case, const OrganOptions& options)
      : StaticCaseModel(load_case.rest, load_case.scene.loads, options) {}
  StaticCaseModel(const StaticCaseModel&) = delete;  // the relaxation refers to the organ
  StaticCaseModel& operator=(const StaticCaseModel&) = delete;

  /// Control points, or vertices; local functions in use.
  int unknowns() const { return static_cast<int>(weights_.cols()); }
  int local_functions() const;
  double setup_ms() const { return setup_ms_; }  ///< Organ, weights and factors.
  const std::optional<OrganModel>& lattice_organ() const { return organ_; }

  /// Takes the body to rest under the case's loads: a force is met by the displacement of its patch
  /// (Newton's method over the few patches, Broyden's update). False when it was not found to 1e-4
  /// of the loads.
  bool Balance();

  /// Takes the patches to where a solution `u` (V x 3, m) has them instead, whatever the force.
  void MoveTo(const Points& u);

  /// Takes other loads, at most as many as it was made for, and goes to rest without any.
  void Reload(const std::vector<LoadOptions>& loads);

  /// Goes to where another body of the same unknowns was taken.
  void StartFrom(const StaticCaseModel& other);

  /// Repeated real-time steps between 0.95 of the loads' displacements and all of them: `response`
  /// repositions and relaxes, `relocation` moves the vertices with the lattice and `indentations`
  /// with what is added at the loads. Ends at rest under all.
  struct StepTimes {
    Timing response, relocation, indentations;
    RelaxationResult last;  ///< Of one step, not of the repeats.
  };
  StepTimes TimeSteps();

  /// V x 3, m.
  Points VertexDisplacements() const;
  /// Of the first load, m/N; 0 without force.
  double Compliance() const;

 private:
  void AddPatches();
  void AddLatticeRow(std::size_t load);
  RelaxationResult Step(const Eigen::VectorXd& displacements);
  void Settle(const Eigen::VectorXd& displacements);
  Eigen::VectorXd Forces() const;
  bool IsDepth(Eigen::Index component) const;  // of the loads' 3 m, given as displacement
  void AddIndentations(Points* vertices) const;

  const SurfaceMesh& rest_;
  std::vector<LoadOptions> loads_;
  OrganOptions options_;
  std::optional<OrganModel> organ_;
  WeightMatrix weights_;  // V x n: the lattice's, or the identity
  std::unique_ptr<Relaxation> relaxation_;
  int slots_ = 0;  // for local functions
  double setup_ms_ = 0;
  ContactConstraints contacts_;
  Points U_;                                    // (n + slots) x 3, m
  std::vector<LocalIndentation> indentations_;  // a load; nothing for the surface models
  Points vertices_;                             // V x 3, m
  ContactWeights patches_;                      // loads x V: the loads' kernels
  Eigen::VectorXd moved_;  // 3 x loads, m: where the patches were taken, without their indentations
};

}  // namespace hpdm
