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

/// How far a replay's force on the hand is from the logged one.
struct ForceDifference {
  double rms = 0;          ///< N, of the length of the difference.
  double peak = 0;         ///< N, its largest.
  double logged_peak = 0;  ///< N, largest force in the log.
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

/// What the haptic loop had been asked for, as far as a tick applied it.
SessionControl ControlOf(const HapticSample& sample);

/// Throws InputError when the log is visibly not of the scene that the session was built from.
void RequireSameScene(const LoggedSession& log, const Session& session);

/// What a replay found.
struct LogReplay {
  FieldComparison comparison{0};
  std::uint64_t ticks_logged = 0;
  std::uint64_t ticks_compared = 0;
  std::uint64_t ticks_without_output = 0;  ///< Replayed, but their output is missing in the log.
  std::uint64_t ticks_lost = 0;            ///< Ran in the session but are not in the log.
  std::uint64_t steps_logged = 0;
  std::uint64_t steps_compared = 0;
  std::string ended_early;  ///< Why the comparison ended before the log did; empty: it did not.
  int tool_count = 0;
  std::array<ForceDifference, kMaxInstruments> forces;
  Histogram tick_compute;  ///< Wall time of the replayed ticks, ns.
};

/// Plays the logged device samples, pauses and exchanges through HapticLoop::Tick and the logged
/// input ticks, times and ends of iteration through DeformationLoop::Step, each patch visible at
/// its logged tick, and compares every field that the ticks and steps of the log have. The state of
/// both loops follows from all that came before, so the comparison ends at the first tick that the
/// log lacks, or that uses a step which it lacks. `session` is built from the log's scene and used
/// up. Throws InputError when the log is of another scene. One thread.
LogReplay ReplayLog(const LoggedSession& log, double tolerance, Session* session);

}  // namespace hpdm
