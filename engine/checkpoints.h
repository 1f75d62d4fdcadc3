#pragma once

#include <optional>
#include <vector>

#include "engine/deformation_loop.h"
#include "engine/snapshots.h"
#include "engine/threads/triple_buffer.h"

namespace hpdm {

/// Keeps the tissue's state at the beginning of each step of an exercise, and returns to it on request:
///
///     telemetry loop --ExerciseProgress--> [Checkpoints] <--RestartRequest-- haptic loop (ToolState)
///                                               |  ^
///                      DeformationLoop::ReturnTo   copies of the DeformationLoop
///
/// The log has both changes (StepRecord::kept_step, restarted_step). Set up on the main thread, then
/// of the deformation thread: it never throws, logs, locks or allocates.
class Checkpoints {
 public:
  /// `steps`: of the exercise.
  explicit Checkpoints(std::size_t steps) : kept_(steps) {}
  /// Makes room for a state of `loop` at each step. Call once, after the loop's construction.
  void MakeRoom(const DeformationLoop& loop);

  /// The edge of the exercise's progress, to be written.
  TripleBuffer<ExerciseProgress>& progress() { return progress_; }

  /// The exercise's steps that Follow() kept and restarted; -1: none.
  struct Change {
    int kept = -1;
    int restarted = -1;
  };
  /// Keeps the loop's state if the exercise has reached another step; returns the loop to a kept one if
  /// the request is new. A request for a step that has not begun does nothing. Call before a step.
  Change Follow(const RestartRequest& request, DeformationLoop* loop);

  /// For a replay: the next Follow() keeps the state as the beginning of this step (-1: of none),
  /// whatever the progress.
  void ApplyRecorded(int kept_step) { recorded_ = kept_step; }

 private:
  int Restart(int step, DeformationLoop* loop);
  int StepToKeep();

  TripleBuffer<ExerciseProgress> progress_;
  std::vector<DeformationLoop> states_;  // by step
  std::vector<bool> kept_;               // by step: its state is one
  int present_ = -1;                     // step of the exercise; -1: it has not begun
  int requests_ = 0;                     // seen
  int restarts_ = 0;                     // done
  std::optional<int> recorded_;
};

}  // namespace hpdm
