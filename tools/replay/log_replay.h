#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "engine/snapshots.h"
#include "engine/threads/histogram.h"
#include "lcmtypes/analysis/logged_session.h"
#include "tools/replay/field_comparison.h"
#include "tools/session/session.h"

namespace hpdm {

/// Difference of the replayed force on the hand from the logged one.
struct ForceDifference {
  double rms = 0;          ///< Root mean square of the difference's length, N.
  double peak = 0;         ///< Largest length of the difference, N.
  double logged_peak = 0;  ///< Largest force in the log, N.
};

/// Sums of force differences.
class ForceDifferences {
 public:
  void Add(const HapticSample& logged, const HapticSample& replayed);
  ForceDifference Of(int tool) const;

 private:
  std::array<ForceDifference, kMaxInstruments> sums_;  // rms: the sum of squares
  std::uint64_t count_ = 0;
};

/// Watches a session while it is replayed. The snapshots are on Session::render_scenes.
class ReplayViewer {
 public:
  virtual ~ReplayViewer() = default;
  /// A tick has been computed.
  virtual void OnTick(const HapticSample& replayed) = 0;
  /// A step of this session time has been computed. Returns false to end the replay.
  virtual bool OnStep(Nanoseconds time_ns) = 0;
};

/// Returns the controls that a tick applied.
SessionControl ControlOf(const HapticSample& sample);

/// Throws InputError if the log is recognisably not of the session's scene.
void RequireSameScene(const LoggedSession& log, const Session& session);

/// Results of a replay.
struct LogReplay {
  FieldComparison comparison{0};
  std::uint64_t ticks_logged = 0;
  std::uint64_t ticks_compared = 0;
  std::uint64_t ticks_without_output = 0;  ///< Replayed ticks whose output is missing in the log.
  std::uint64_t ticks_lost = 0;            ///< Ticks of the session that are not in the log.
  std::uint64_t steps_logged = 0;
  std::uint64_t steps_compared = 0;
  std::string ended_early;  ///< Why the comparison ended before the log; empty if it did not.
  bool stopped = false;     ///< The viewer ended it.
  int tool_count = 0;
  std::array<ForceDifference, kMaxInstruments> forces;
  Histogram tick_compute;  ///< Wall time of the replayed ticks, ns.
};

/// Recomputes a logged session and compares every field of its ticks and steps:
///   1. HapticLoop::Tick gets the logged device samples, pauses and exchanges;
///   2. DeformationLoop::Step gets the logged input ticks, times and ends of iteration;
///   3. each patch becomes visible at its logged tick.
/// The state of both loops depends on everything before, so the comparison ends at the first tick
/// that is missing in the log or that used a missing step. `session` is built from the log's scene
/// and used up. `viewer` may be null. Throws InputError if the log is of another scene. One thread.
LogReplay ReplayLog(const LoggedSession& log, double tolerance, Session* session,
                    ReplayViewer* viewer = nullptr);

}  // namespace hpdm
