#pragma once

#include <array>
#include <cstdint>

#include "engine/snapshots.h"
#include "engine/threads/latency.h"
#include "hpdm/stats_t.hpp"
#include "lcmtypes/analysis/slip_counter.h"

namespace hpdm {

/// Sums of one instrument. A tick is in contact if its ToolSample::kind is not kNone. It lasts
/// until the next tick: periods skipped after it count with it, since the device holds its force.
struct ToolSummary {
  double peak_force = 0;     ///< N, largest |TissueForce()|.
  double mean_force = 0;     ///< N, mean |TissueForce()| over the contact time.
  double contact_time = 0;   ///< s.
  double deepest_press = 0;  ///< m, largest depth of the tip below the released surface.
  int slips = 0;             ///< Times that tissue slipped through the jaws (SlipCounter).
};

/// Results of a session.
struct SessionSummary {
  std::uint64_t ticks = 0;       ///< That reached the telemetry.
  std::uint64_t ticks_lost = 0;  ///< Run, but lost on the way (queue overflow).
  SkippedTicks skipped;          ///< Not run, by cause.
  std::uint64_t steps = 0;       ///< That reached the telemetry.
  std::uint64_t steps_lost = 0;  ///< Run, but lost on the way (queue overflow).
  std::uint64_t steps_shed = 0;  ///< Steps of reduced quality (kStepShed).
  std::uint64_t frames = 0;      ///< That reached the telemetry.
  double haptic_hz = 0;          ///< Ticks run a second, between the first and the last.
  double deformation_hz = 0;     ///< Steps a second, lost ones included.
  Latencies latencies;        ///< Ages and device-to-force once there is a patch, a valid sample.
  Nanoseconds stolen_ns = 0;  ///< CPU steal time.
  int tool_count = 0;
  std::array<ToolSummary, kMaxInstruments> tools;
};

/// Statistics of a session and of the current interval. Counts and sums only: the same samples give
/// the same figures. One thread; allocates only as the message's bins grow.
class SessionStatistics {
 public:
  /// `haptic_period` (ns) is the length of the last tick. `baseline` holds the wake-ups of an empty
  /// loop before the session, for comparison with the session's.
  explicit SessionStatistics(Nanoseconds haptic_period, const Histogram& baseline = {});

  /// Add samples, steps and frames, each kind in its order.
  void Add(const HapticSample& sample);
  void Add(const StepRecord& step);
  void Add(const FrameRecord& frame);
  /// Adds the CPU steal time since the last call, ns.
  void AddStolen(Nanoseconds stolen);

  /// Fills in the interval's fields of `stats` (all but the sequence number and the counts of the
  /// queues, the log and the network) and starts the next interval at `end`.
  void CloseInterval(Nanoseconds end, stats_t* stats);
  /// True if nothing was added since the last CloseInterval.
  bool interval_empty() const {
    return interval_.ticks == 0 && interval_.steps == 0 && interval_.frames == 0;
  }
  Nanoseconds interval_start() const { return interval_.start; }

  /// Sums so far: a Summary without its rates and without the values that need the length of a
  /// contact. Copies nothing.
  const SessionSummary& sums() const { return total_; }
  /// Summary so far; the last tick counts one period.
  SessionSummary Summary() const;

 private:
  struct Interval {
    Nanoseconds start = 0;
    std::int64_t ticks = 0;
    std::int64_t steps = 0;
    std::int64_t steps_lost = 0;
    std::int64_t steps_shed = 0;
    std::int64_t frames = 0;
    SkippedTicks skipped;
    Nanoseconds stolen = 0;
    Latencies latencies;
  };
  struct ToolHold {  // what the last tick left standing, and the sums up to it
    double force = 0;
    bool contact = false;
    SlipCounter slips;
    std::uint64_t contact_periods = 0;
    double force_periods = 0;
  };
  void Hold(std::uint64_t periods);
  void Count(Latency which, Nanoseconds duration);

  Nanoseconds haptic_period_;
  Nanoseconds paused_until_ns_ = -1;  // device samples up to it are as old as the pause is long
  Interval interval_;
  SessionSummary total_;
  std::array<ToolHold, kMaxInstruments> holds_;
  std::uint64_t last_tick_ = 0, last_step_ = 0;
  std::uint64_t lost_between_ = 0;  // steps lost after the first that came
  bool baseline_sent_ = false;
  Nanoseconds last_wake_up_ns_ = 0, last_step_wake_up_ns_ = 0, last_picture_ns_ = 0;
  Nanoseconds first_tick_ns_ = 0, last_tick_ns_ = 0, first_step_ns_ = 0, last_step_ns_ = 0;
};

}  // namespace hpdm
