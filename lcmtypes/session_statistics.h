#pragma once

#include <array>
#include <cstdint>

#include "engine/histogram.h"
#include "engine/snapshots.h"
#include "hpdm/stats_t.hpp"

namespace hpdm {

/// What one instrument did. "In contact" is a tick whose ToolSample::kind is not kNone; a tick
/// stands until the next one, so the periods skipped after it (the device holds its force) count
/// with it.
struct ToolSummary {
  double peak_force = 0;     ///< N, largest |force on the hand| sent.
  double mean_force = 0;     ///< N, mean |force on the hand| over the contact time.
  double contact_time = 0;   ///< s.
  double deepest_press = 0;  ///< m, largest depth of the tip below the released surface.
};

/// A session in figures. Durations in the histograms are ns.
struct SessionSummary {
  std::uint64_t ticks = 0;       ///< That reached the telemetry.
  std::uint64_t ticks_lost = 0;  ///< Run, but lost on the way (queue overflow).
  SkippedTicks skipped;          ///< Not run, by cause.
  std::uint64_t steps = 0;       ///< That reached the telemetry.
  std::uint64_t steps_lost = 0;  ///< Run, but lost on the way (queue overflow).
  double haptic_hz = 0;          ///< Ticks run a second, between the first and the last.
  double deformation_hz = 0;     ///< Steps a second, likewise, lost ones included.
  Histogram wake_late;           ///< Haptic wake-up minus schedule.
  Histogram compute;             ///< Of a haptic tick.
  Histogram patch_age;           ///< At the haptic tick, once there is a patch.
  Histogram step_compute;        ///< Of a deformation step.
  int tool_count = 0;
  std::array<ToolSummary, kMaxInstruments> tools;
};

/// Statistics of a session and of the current interval. Counts and sums only: the same samples give
/// the same figures. One thread; no allocation.
class SessionStatistics {
 public:
  /// `haptic_period` (ns): how long the last tick counts.
  explicit SessionStatistics(Nanoseconds haptic_period);

  /// Samples and steps in the order of their numbers.
  void Add(const HapticSample& sample);
  void Add(const StepRecord& step);

  /// Fills in the interval's fields of `stats` (all but the sequence number and the counts of the
  /// queue, the log and the network) and starts the next interval at `end`.
  void CloseInterval(Nanoseconds end, stats_t* stats);
  /// Whether anything was added since the last CloseInterval.
  bool interval_empty() const { return interval_.ticks == 0 && interval_.steps == 0; }
  Nanoseconds interval_start() const { return interval_.start; }

  /// Of everything added so far; the last tick counts one period.
  SessionSummary Summary() const;

 private:
  struct Interval {
    Nanoseconds start = 0;
    std::int64_t ticks = 0;
    std::int64_t steps = 0;
    std::int64_t steps_lost = 0;
    SkippedTicks skipped;
    Histogram wake_late, compute, patch_age, step_compute;
  };
  struct ToolHold {  // what the last tick left standing, and the sums up to it
    double force = 0;
    bool contact = false;
    std::uint64_t contact_periods = 0;
    double force_periods = 0;
  };
  void Hold(std::uint64_t periods);

  Nanoseconds haptic_period_;
  Interval interval_;
  SessionSummary total_;
  std::array<ToolHold, kMaxInstruments> holds_;
  std::uint64_t last_tick_ = 0, last_step_ = 0;
  std::uint64_t lost_between_ = 0;  // steps lost after the first that came
  Nanoseconds first_tick_ns_ = 0, last_tick_ns_ = 0, first_step_ns_ = 0, last_step_ns_ = 0;
};

}  // namespace hpdm
