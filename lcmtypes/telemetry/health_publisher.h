#pragma once

#include <cstdint>

#include "engine/snapshots.h"
#include "engine/threads/triple_buffer.h"
#include "lcmtypes/telemetry/session_statistics.h"

namespace hpdm {

/// Publishes the session's figures for the render loop, 10 times a second of session time.
///
/// Thread: that of its owner, which writes the buffer. Guarantee: a call never waits or allocates.
class HealthPublisher {
 public:
  /// `out` may be null: nothing is then published.
  explicit HealthPublisher(TripleBuffer<SessionHealth>* out) : out_(out) {}

  void Add(const HapticSample& sample);
  void Add(const StepRecord& step);
  void Add(const ExerciseStatus& exercise) { health_.exercise = exercise; }
  /// Takes the rates of the last interval.
  void Add(const stats_t& interval);

  /// Publishes if it is time. `log_lost`: ticks that the log missed.
  void Publish(Nanoseconds now, const SessionSummary& sums, std::uint64_t log_lost);

 private:
  TripleBuffer<SessionHealth>* out_;
  SessionHealth health_;
};

}  // namespace hpdm
