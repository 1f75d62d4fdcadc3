#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/attachment/attached_compliance.h"
#include "engine/attachment/attachment_options.h"
#include "engine/base/copying.h"
#include "engine/duct/duct_options.h"
#include "engine/organ/organ_state.h"
#include "engine/snapshots.h"
#include "engine/step/duct_actions.h"
#include "engine/step/joint_relaxation.h"
#include "engine/step/layer_actions.h"
#include "engine/step/load_shedding.h"
#include "engine/step/organ_contacts.h"
#include "engine/step/organ_step.h"
#include "engine/step/tool_tracker.h"
#include "engine/step/wall_actions.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"

namespace hpdm {

class Checkpoints;

/// The edges of the deformation loop (snapshots.h): it reads `tools` and writes the others. A scene
/// without organs is not filled in: nobody reads it.
struct DeformationEdges {
  TripleBuffer<ToolState>& tools;
  TripleBuffer<ContactPatch>& patch;
  TripleBuffer<SceneSnapshot>& render;
  TripleBuffer<SceneSnapshot>& telemetry;
  SpscQueue<StepSample>* steps = nullptr;  ///< nullptr: steps are not recorded.
  Checkpoints* checkpoints = nullptr;      ///< nullptr: an exercise cannot restart at a step.
};

/// The 30 Hz loop: deforms the organs under the tools (stages: engine/README.md, section 6). An
/// organ that is untouched and at rest sleeps: a step then only tests its bounding box against the
/// tools. A touch wakes it within the step.
///
/// All methods but the constructor belong to the deformation thread; they never throw, log or lock.
class DeformationLoop {
 public:
  /// `organs` and the channels in `edges` must outlive the loop. The scenes on the edges start with
  /// the organs at rest (SizedSnapshot); a step writes only shapes newer than the slot's.
  /// `stopwatch` gives the session time for StepRecord::compute_ns; nullptr (lockstep): nothing is
  /// measured. Steps longer than `budget` (ns) lower the organs' quality (load_shedding.h); 0: no
  /// limit. `attachments`, `ducts`: of the organs, which TakesAttachments(); throws InputError as
  /// AttachmentBed and DuctModel do.
  DeformationLoop(const std::vector<OrganModel>& organs, const std::vector<ToolOptions>& tools,
                  const DeformationEdges& edges, std::function<Nanoseconds()> stopwatch = nullptr,
                  Nanoseconds budget = 0, const std::vector<AttachmentOptions>& attachments = {},
                  const std::vector<DuctOptions>& ducts = {});

  /// A copy continues from the same state to the last bit, once it is attached to edges of its own.
  /// An assignment keeps the organs' arrays in place if they are of the same meshes.
  DeformationLoop(const DeformationLoop&) = default;
  DeformationLoop& operator=(const DeformationLoop&) = default;
  void Attach(const DeformationEdges& edges) {
    edges_ = edges;
    for (OrganStep& organ : organs_) organ.Rebind();
  }

  /// Runs one step at session time `now_ns` from the given tool state and publishes it on all
  /// edges. A tool whose pose is not finite keeps its last pose. `wake_late_ns` is the wake-up
  /// lateness for the step's record.
  void Step(const ToolState& given, Nanoseconds now_ns, Nanoseconds wake_late_ns = 0);

  /// Returns the tissue to the state of `kept`, a copy of this loop. Its time, its step number and the
  /// poses of its tools continue. All tools let go of what they hold; jaws that are closed hold
  /// nothing until they open.
  void ReturnTo(const DeformationLoop& kept);

  /// For a replay: the next Step uses the recorded quality, and keeps the state if the recorded one did.
  /// A relaxation that was out of time then stops after the recorded number of iterations.
  void ApplyRecorded(const StepSample& recorded);

  /// The newest tool state on the edge.
  const ToolState& NewestTools();

  /// Fills in a scene of SizedSnapshot() after the last step, as on the edges: shapes newer than
  /// the scene's.
  void Show(SceneSnapshot* scene) const { FillScene(tools_, scene); }

  /// Record of the last step.
  const StepRecord& record() const { return record_; }
  /// Returns all that is recorded of the last step.
  const StepSample& sample() const { return sample_; }
  const OrganState& organ(int i) const { return organs_[i].state(); }
  /// The joints of organs that attachments and ducts connect.
  std::span<const AttachmentLink> links() const { return joint_relaxation_.links(); }

 private:
  // Set-up (deformation_loop_setup.cc):
  using JoinedPair = std::array<AttachmentJoint::Organ, 2>;
  void Join(const std::vector<AttachmentOptions>& attachments,
            const std::vector<DuctOptions>& ducts);
  std::vector<AttachmentBed> MakeBeds(const std::vector<AttachmentOptions>& attachments,
                                      std::vector<JoinedPair>* pairs);
  std::vector<std::shared_ptr<const DuctModel>> MakeDucts(const std::vector<DuctOptions>& ducts,
                                                          std::vector<JoinedPair>* pairs);
  AttachmentJoint::Organ JoinedOrganOf(const std::string& name) const;
  void HoldOrgans(const AttachmentLink& link);

  void FollowExercise(const RestartRequest& request);
  void ChooseQuality();
  const ToolState& SanitisedTools(const ToolState& given);
  void Collide(const ToolState& tools);
  void Refine(int tool_count);
  void Deform(double dt);
  void LetGo();
  void BuildContactPatch(const ToolState& tools);
  bool Acts(std::size_t tool, const ToolPose& pose, ToolAction action) const;
  void MoveSmoke(const ToolState& tools);
  void ObserveLoad();
  void FillSample(const ToolState& tools);
  void FillTensions();
  void FillLumens();
  SolvedContact InWorld(SolvedContact contact) const;
  void Publish(const ToolState& tools);
  void FillScene(const ToolState& tools, SceneSnapshot* scene) const;

  Rebindable<DeformationEdges> edges_;
  std::function<Nanoseconds()> stopwatch_;
  std::vector<OrganStep> organs_;
  std::vector<ToolTracker> trackers_;  // one per tool
  OrganContacts organ_contacts_;
  JointRelaxation joint_relaxation_;
  JawClosings jaw_closings_;
  LayerActions layer_actions_;
  DuctActions duct_actions_;
  WallActions wall_actions_;
  WorkMatrix loads_{0, 0};  // 3 (n + slots) x equations, of the largest organ; empty without pairs
  AttachedCompliance::Work attached_work_;
  LoadShedding shedding_;
  std::array<OrganRelaxation, kMaxOrgans> recorded_;  // for the next step, in a replay
  std::size_t recorded_count_ = 0;
  std::vector<std::vector<ToolAction>> actions_;  // [tool][ToolPose::instrument_index]
  Smoke smoke_;
  ToolState tools_;  // last step's tools, all finite
  StepRecord record_;
  StepSample sample_;
};

/// Returns a snapshot of the rest state whose arrays have the organs' sizes. Readers that rebuild
/// the vertices get none. `beds`, `ducts`: those of the scene, for readers that draw them.
SceneSnapshot SizedSnapshot(const std::vector<OrganModel>& organs, int tool_count,
                            bool with_vertices, std::span<const AttachmentBed> beds = {},
                            std::span<const DuctModel> ducts = {});

}  // namespace hpdm
