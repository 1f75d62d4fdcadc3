#pragma once

#include <functional>
#include <vector>

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "engine/step/inversion_recovery.h"
#include "engine/step/load_shedding.h"
#include "engine/step/strain_blend_controller.h"
#include "engine/step/tool_tracker.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"

namespace hpdm {

/// The edges of the deformation loop (snapshots.h): one reader's end, four writers' ends.
struct DeformationEdges {
  TripleBuffer<ToolState>& tools;
  TripleBuffer<ContactPatch>& patch;
  TripleBuffer<SceneSnapshot>& render;
  TripleBuffer<SceneSnapshot>& telemetry;
  SpscQueue<StepSample>* steps = nullptr;  ///< nullptr: nobody keeps every step.
};

/// The ~30 Hz loop: moves the organs under the tools (stages: engine/README.md, section 6). An
/// organ sleeps while nothing touches it and it is at rest: then a step asks its tree's outermost
/// box whether a tool is near, and no more. What touches it wakes it within the step.
///
/// All methods but the constructor belong to the deformation thread; they never throw, log or lock.
class DeformationLoop {
 public:
  /// `organs` and what `edges` names must outlive the loop. The scenes on the edges have the organs
  /// at rest (SizedSnapshot): a step writes the shapes that are newer than a slot's. `stopwatch`
  /// gives the session time for StepRecord::compute_ns; without one (lockstep) nothing is measured.
  /// Steps that take longer than `budget` (ns) lower the organs' quality (load_shedding.h); 0: none
  /// does.
  DeformationLoop(const std::vector<OrganModel>& organs, const std::vector<ToolOptions>& tools,
                  const DeformationEdges& edges, std::function<Nanoseconds()> stopwatch = nullptr,
                  Nanoseconds budget = 0);

  /// One step, begun at session time `now_ns`, from the given tool state; published on all edges. A
  /// tool whose pose is not finite counts as where it was.
  /// `wake_late_ns`: what the schedule measured, for the step's record.
  void Step(const ToolState& given, Nanoseconds now_ns, Nanoseconds wake_late_ns = 0);

  /// For a replay: the next Step takes the recorded one's quality, and where a relaxation of that
  /// was out of time, stops after as many iterations.
  void ApplyRecorded(const StepSample& recorded);

  /// The newest tool state on the edge.
  const ToolState& NewestTools();

  /// How the last step went.
  const StepRecord& record() const { return record_; }
  const OrganState& organ(int i) const { return states_[i]; }

 private:
  void ChooseQuality();
  const ToolState& SanitisedTools(const ToolState& given);
  void Collide(const ToolState& tools);
  void Refine(int tool_count);
  void WakeTouched();
  void RepositionControlPoints();
  void Relax(double dt);
  void RelocateVertices();
  bool AtRest(std::size_t organ) const;
  void BuildContactPatch(const ToolState& tools);
  void ObserveLoad();
  void FillSample(const ToolState& tools);
  void Publish(const ToolState& tools);
  void FillScene(const ToolState& tools, SceneSnapshot* scene) const;

  const std::vector<OrganModel>& models_;
  DeformationEdges edges_;
  std::function<Nanoseconds()> stopwatch_;
  std::vector<OrganState> states_;
  std::vector<InversionRecovery> inversion_recoveries_;   // one an organ
  std::vector<ToolTracker> trackers_;                     // one a tool
  std::vector<StrainBlendController> blend_controllers_;  // one an organ
  LoadShedding shedding_;
  bool applies_recorded_ = false;  // the next step's quality is a recorded one
  ToolState tools_;                // of the last step, all finite
  StepRecord record_;
  StepSample sample_;
};

/// A snapshot of the rest state whose arrays have the organs' sizes; without vertices for readers
/// that rebuild them.
SceneSnapshot SizedSnapshot(const std::vector<OrganModel>& organs, int tool_count,
                            bool with_vertices);

}  // namespace hpdm
