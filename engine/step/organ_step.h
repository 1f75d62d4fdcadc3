#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "engine/organ/organ_state.h"
#include "engine/snapshots.h"
#include "engine/step/inversion_recovery.h"
#include "engine/step/strain_blend_controller.h"

namespace hpdm {

/// One organ's part in the deformation loop: its state, the quality of its next step, and its
/// recovery from inversions. DeformationLoop::Step calls the methods in their order here, each for
/// all organs. Deformation thread; never throws or allocates.
class OrganStep {
 public:
  /// `model` must outlive it. `tools`, `clock`: see OrganState.
  OrganStep(const OrganModel& model, int tools, std::function<Nanoseconds()> clock);

  const OrganModel& model() const { return *model_; }
  OrganState& state() { return state_; }
  const OrganState& state() const { return state_; }

  /// For a replay: the next step uses the recorded quality and stops where the recorded step did.
  void ApplyRecorded(const OrganRelaxation& recorded);
  /// Sets the quality of this step from the state after the last one.
  void ChooseQuality(const QualityCeiling& ceiling);

  /// Moves the organ to its breathing offset at `time_ns`, refits its tree and drops its contacts.
  void Begin(Nanoseconds time_ns);
  /// Places the local functions at the tips' rest points `p_rest_W` (m). `step`: its number.
  void Refine(std::span<const Vector3d> p_rest_W, std::uint64_t step);
  /// Wakes a touched organ.
  void Wake() { state_.awake = state_.awake || state_.contacts.size() > 0; }

  /// Stage A (Eq. 26-28): moves the contacts to their targets by the least change of the lattice.
  void RepositionControlPoints();
  /// Stage B: minimises the energy under the contacts, `dt` (s) after the last step. Adds its
  /// iterations, residual and flags to `record`.
  void Relax(double dt, StepRecord* record);
  /// Stage C (Eq. 4): x = X + B U. An organ at rest then falls asleep. `step`: its number.
  void RelocateVertices(std::uint64_t step);

  /// The last step, as it is logged.
  OrganRelaxation Outcome() const;
  /// True if the last step had the quality that the ceiling and the state ask for.
  bool QualitySettled() const { return blend_controller_.settled(); }
  /// Fills in what is newer than the snapshot's version.
  void FillSnapshot(OrganSnapshot* shape) const;

 private:
  bool AtRest() const;

  const OrganModel* model_;
  OrganState state_;
  InversionRecovery inversion_recovery_;
  StrainBlendController blend_controller_;
  bool applies_recorded_ = false;  // the next step's quality is a recorded one
};

}  // namespace hpdm
