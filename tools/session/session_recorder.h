#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/snapshots.h"
#include "engine/threads/spsc_queue.h"
#include "engine/threads/triple_buffer.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "tools/session/session_folder.h"
#include "tools/session/session_model.h"

namespace hpdm {

/// Records a LockstepSession in a session folder, which `hpdm log`, `replay` and `report` read. The
/// log has the bytes of one that `hpdm run --clock lockstep` writes.
///
/// One thread: the session's, which waits for the disk. Between two drains the queues hold what comes
/// in a second; more is counted as lost.
class SessionRecorder {
 public:
  /// Creates the folder with the scene and its log. `live`: publishes over LCM too, on NetworkUrl().
  /// Throws InputError if a file cannot be written, if the model is not that of its scene's file or if
  /// the network's address is none, and MachineError if the network cannot be opened; then no folder stays.
  SessionRecorder(const SessionModel& model, const std::filesystem::path& folder, bool live);
  ~SessionRecorder() { Finish(); }
  SessionRecorder(const SessionRecorder&) = delete;
  SessionRecorder& operator=(const SessionRecorder&) = delete;

  /// Takes what the loops write in a tick and in a step.
  void Add(const HapticSample& sample) noexcept { samples_.Push(sample); }
  void Add(const StepSample& sample) noexcept { steps_.Push(sample); }
  /// Where the deformation loop publishes its scenes.
  TripleBuffer<SceneSnapshot>& scenes() noexcept { return scenes_; }
  /// Writes everything that it was given so far. Finish() returns the failures.
  void Drain() noexcept { telemetry_->Drain(); }

  /// Ends the log. Returns why it is not complete, in one sentence with the remedy; else empty.
  /// Later calls return the same.
  std::string Finish();

 private:
  SessionFolder folder_;
  SpscQueue<HapticSample> samples_;
  SpscQueue<StepSample> steps_;
  TripleBuffer<SceneSnapshot> scenes_;
  std::optional<TelemetryLoop> telemetry_;
};

}  // namespace hpdm
