#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include "engine/organ/organ_state.h"
#include "engine/snapshots.h"
#include "engine/solver/contact_body.h"
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

  /// After a copy: what the copied relaxation is part of refers to the copy.
  void Rebind() {
    state_.memory.Rebind(*state_.relaxation);
    inversion_recovery_.Rebind(*state_.relaxation);
  }

  /// For a replay: the next step uses the recorded quality and stops where the recorded step did.
  void ApplyRecorded(const OrganRelaxation& recorded);
  /// Sets the quality of this step from the state after the last one.
  void ChooseQuality(const QualityCeiling& ceiling);

  /// Moves the organ to its breathing offset at `time_ns`, refits its tree and drops its contacts.
  void Begin(Nanoseconds time_ns);
  /// Places the local functions at the tips' rest points `p_rest_W` (m). `step`: its number.
  void Refine(std::span<const Vector3d> p_rest_W, std::uint64_t step);
  /// Takes out of the lumens what they lose in a step at `now_s`, `dt` (s) after the last one.
  void Leak(double now_s, double dt) { state_.leaks.Advance(now_s, dt); }
  /// Wakes an organ that a tool touches or that leaks.
  void Wake() {
    state_.awake = state_.awake || state_.contacts.tool_rows() > 0 || state_.leaks.IsActive();
  }

  /// Stage A (Eq. 26-28): moves the contacts to their targets by the least change of the lattice.
  void RepositionControlPoints();
  /// Stage B minimises the energy under the contacts, `dt` (s) after the last step: BeginRelax(),
  /// the solve (Body() with others, or RelaxAlone()), once more if Rejects(), EndRelax().
  void BeginRelax(double dt) { inversion_recovery_.Begin(dt, &state_); }
  /// The organ as a body of the contact problem; without a body if its solver takes none.
  BodyInStep Body();
  /// For an organ without a body.
  RelaxationResult RelaxAlone();
  /// True if the organ must be relaxed once more.
  bool Rejects(const RelaxationResult& result) {
    return inversion_recovery_.Rejects(result, &state_);
  }
  /// True after BeginRelax() if Rejects() may be true.
  bool MayReject() const { return inversion_recovery_.MayReject(); }
  /// Adds the iterations, residual and flags to `record`.
  void EndRelax(const RelaxationResult& result, StepRecord* record);
  /// Wakes an organ that an attachment has moved.
  void WakeIfMoved() { state_.awake = state_.awake || !state_.control_displacements.isZero(0); }
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
  RelaxationInput Input() const;
  bool IsPressedByOrgans() const;

  const OrganModel* model_;
  OrganState state_;
  InversionRecovery inversion_recovery_;
  StrainBlendController blend_controller_;
  bool applies_recorded_ = false;  // the next step's quality is a recorded one
};

}  // namespace hpdm
