#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/checkpoints.h"
#include "engine/deformation_loop.h"
#include "engine/exercise/exercise_evaluator.h"
#include "engine/threads/triple_buffer.h"
#include "haptics/haptic_loop.h"
#include "lcmtypes/telemetry/event_reporter.h"
#include "tools/session/device_choice.h"
#include "tools/session/lockstep.h"
#include "tools/session/session_devices.h"
#include "tools/session/session_model.h"

namespace hpdm {

class SessionRecorder;

/// What a program sees of one instrument after a step: the last tick's values, world axes.
struct ToolView {
  std::array<double, 3> force{};       ///< On the hand, as sent to the device, N.
  std::array<double, 3> tip{};         ///< Centre of the tip, m.
  std::array<double, 3> velocity{};    ///< Of the tip, filtered, m/s.
  std::array<double, 4> rotation{};    ///< Of the tool frame, unit quaternion x, y, z, w.
  std::array<double, 5> joints{};      ///< pitch, yaw (rad), insertion (m), roll (rad), jaw (0..1).
  double jaw = 1;                      ///< 0 closed .. 1 open.
  double depth = 0;                    ///< Press: tip below the released surface, m.
  double slip = 0;                     ///< Grasp: way of the tissue through the jaws, m.
  std::int32_t organ = -1;             ///< Index of the organ in contact; -1: none.
  std::int32_t kind = 0;               ///< ContactKind: 0 none, 1 press, 2 grasp.
  std::array<double, 3> step_force{};  ///< Mean force on the hand over the step's ticks, N.
  double peak_force = 0;               ///< Largest force on the hand in the step's ticks, N.
};

/// Something that a session reports, as on the channel HPDM_EVENT.
struct SessionEvent {
  Nanoseconds time_ns = 0;
  EventSeverity severity = EventSeverity::kInfo;
  std::string name, text;
};

/// A session for programs: one thread, virtual time and no clock; no log and no network unless it
/// is recorded. The same bits in every run as those of `hpdm run --clock lockstep`.
///
/// The state is a value: a copy continues from it to the last bit, and so does a session after an
/// assignment. An assignment keeps the arrays of organs and tools in place. Any number of sessions
/// share one model. One thread at a time.
class LockstepSession {
 public:
  /// Starts a session of `model` with a device for each instrument. `seed` replaces that of the
  /// simulated hands unless it is 0. Throws InputError.
  LockstepSession(std::shared_ptr<const SessionModel> model, std::vector<DeviceChoice> devices,
                  std::uint32_t seed = 0);
  LockstepSession(const LockstepSession& other);
  /// Takes over the other's state; both are of the same scene, up to the stiffness of the tissue.
  LockstepSession& operator=(const LockstepSession& other);

  /// Returns to the start, as a new session with this seed.
  void Reset(std::uint32_t seed = 0);
  /// Gives an organ another Young's modulus (Pa) and returns to the start. Builds the organ anew.
  /// Throws InputError.
  void SetYoung(std::size_t organ, double young, std::uint32_t seed = 0);

  const SessionModel& model() const { return *model_; }
  std::shared_ptr<const SessionModel> shared_model() const { return model_; }
  const std::vector<DeviceChoice>& devices() const { return choices_; }
  /// True if another session's state can be assigned.
  bool Fits(const LockstepSession& other) const;

  /// For an instrument with DeviceChoice::kCommand: where the next Step() moves it (finite).
  void Command(std::size_t instrument, const JointVector& joints);
  /// Gives a hand another of its instruments as soon as its tip is free (ToolPose).
  void Exchange(std::size_t instrument, int instrument_index);
  /// Presses or releases the pedal of an instrument, from the next tick on.
  void Press(std::size_t instrument, bool pressed);

  /// Keeps the beginnings of the exercise's steps from now on, so that it can Restart(). Like a recorder
  /// it is not copied, and a Reset(), SetYoung() or an assignment takes it away.
  void KeepSteps();
  /// Returns the tissue and the exercise to the beginning of a step that has begun since KeepSteps(),
  /// with the next deformation step. All instruments let go.
  void Restart(int step);

  /// Computes one deformation step and the ticks of its period. A step takes the tools of its first
  /// tick and shows `patch_delay_ticks` later, so organs and contacts answer in the next call.
  void Step();

  /// Hands everything that follows to `recorder`; null: to none. A log begins at the start (no steps
  /// yet). The recorder outlives this or its place here. Copies have none, and an assignment, a
  /// Reset() and SetYoung() take it away, since the course that it records ends there.
  void RecordTo(SessionRecorder* recorder);

  std::uint64_t steps() const { return steps_; }
  Nanoseconds time_ns() const {
    return static_cast<Nanoseconds>(clock_.tick()) * model_->haptic_period_ns();
  }
  /// The newest tick.
  const HapticSample& sample() const { return sample_; }
  /// The force on each hand in each tick of the last step, N: tick by tick, tools() x 3.
  const std::vector<double>& tick_forces() const { return tick_forces_; }
  const std::vector<ToolView>& tools() const { return tools_; }
  std::vector<ToolView>& tools() { return tools_; }
  /// The force of all instruments on each organ in the last tick, N: organs x 3.
  const std::vector<double>& organ_forces() const { return organ_forces_; }
  std::vector<double>& organ_forces() { return organ_forces_; }
  const OrganState& organ(std::size_t i) const { return deformation_.organ(static_cast<int>(i)); }
  const StepRecord& record() const { return deformation_.record(); }
  std::span<const AttachmentLink> links() const { return deformation_.links(); }
  /// The judgement of the scene's exercise; none if it has none. The session continues after its end.
  const std::optional<ExerciseEvaluator>& exercise() const { return exercise_; }
  /// Fills in a scene of SizedSnapshot() for a picture.
  void Show(SceneSnapshot* scene) const { deformation_.Show(scene); }

  /// The events since the start or the last ClearEvents().
  const std::vector<SessionEvent>& events() const { return events_; }
  void ClearEvents() { events_.clear(); }

 private:
  void MakeDevices(std::uint32_t seed);
  void AttachLoops();
  void CopyEdges(const LockstepSession& other);
  HapticLoop::Edges HapticEdges();
  DeformationEdges StepEdges();
  void StepIfDue();
  void Observe();
  void ObserveStart();

  std::shared_ptr<const SessionModel> model_;
  std::vector<DeviceChoice> choices_;
  std::shared_ptr<const std::vector<TraceFile>> traces_;
  std::shared_ptr<const LockstepSession> start_;  // null in a start itself
  std::vector<std::unique_ptr<Device>> devices_;

  // The edges. The queues are empty between two calls.
  TripleBuffer<ToolState> tool_states_ = TripleBuffer<ToolState>::OfOneThread();
  TripleBuffer<ContactPatch> patches_ = TripleBuffer<ContactPatch>::OfOneThread();
  TripleBuffer<SceneSnapshot> nobody_ = TripleBuffer<SceneSnapshot>::OfOneThread();
  TripleBuffer<SessionControl> control_ = TripleBuffer<SessionControl>::OfOneThread();
  SpscQueue<HapticSample> samples_{1};
  SpscQueue<StepSample> step_samples_{1};
  std::unique_ptr<Checkpoints> checkpoints_;  // not copied
  SessionRecorder* recorder_ = nullptr;       // not copied; before the loop that publishes to it

  HapticLoop haptics_;
  DeformationLoop deformation_;
  Lockstep clock_;

  std::uint64_t steps_ = 0;
  HapticSample sample_;
  std::vector<double> tick_forces_;
  std::vector<ToolView> tools_;
  std::vector<double> organ_forces_;
  EventReporter reporter_;
  std::optional<ExerciseEvaluator> exercise_;
  std::vector<SessionEvent> events_;
};

}  // namespace hpdm
