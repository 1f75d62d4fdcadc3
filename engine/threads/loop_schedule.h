#pragma once

#include <cstdint>
#include <limits>
#include <stop_token>

#include "engine/snapshots.h"
#include "engine/threads/session_clock.h"

namespace hpdm {

/// The clock of a loop: session time, the thread's own CPU time, and an absolute sleep.
class LoopClock {
 public:
  virtual ~LoopClock() = default;
  virtual Nanoseconds Now() noexcept = 0;                  ///< Session time, monotonic.
  virtual Nanoseconds ThreadCpuTime() noexcept = 0;        ///< CPU time of the calling thread.
  virtual void SleepUntil(Nanoseconds time) noexcept = 0;  ///< Returns at `time` or later.
};

/// The session's real clock. No allocation.
class RealLoopClock : public LoopClock {
 public:
  explicit RealLoopClock(const SessionClock& clock) : clock_(clock) {}
  Nanoseconds Now() noexcept override { return clock_.Now(); }
  Nanoseconds ThreadCpuTime() noexcept override { return hpdm::ThreadCpuTime(); }
  void SleepUntil(Nanoseconds time) noexcept override { clock_.SleepUntil(time); }

 private:
  SessionClock clock_;
};

/// Timing of a tick, given to it. In lockstep it has the defaults: nothing is measured.
struct TickTiming {
  Nanoseconds wake_late_ns = 0;  ///< Wake-up minus schedule.
  SkippedTicks skipped = {};     ///< Periods skipped just before this tick.
  LoopClock* clock = nullptr;    ///< For the tick to measure its own compute time; null: 0.
};

/// Lateness of the wake-up before a tick: the tick's `wake_late_ns` plus the periods missed by
/// waking late.
inline Nanoseconds WakeUpLateness(Nanoseconds wake_late_ns, const SkippedTicks& skipped,
                                  Nanoseconds period_ns) {
  return wake_late_ns + static_cast<Nanoseconds>(skipped.late_wake_up) * period_ns;
}

/// Period k of a schedule is [start + k period, start + (k + 1) period).
struct TickSchedule {
  Nanoseconds start_ns = 0;  ///< Session time of tick 0.
  Nanoseconds period_ns = 1'000'000;
  std::uint64_t end_tick = std::numeric_limits<std::uint64_t>::max();  ///< First one not to run.
};

/// Counts of ticks and skipped periods; every period up to the end is in exactly one of them.
struct TickCount {
  std::uint64_t ticks = 0;
  SkippedTicks skipped;
  std::uint64_t Periods() const { return ticks + skipped.Total(); }
};

/// Runs `body(tick, scheduled, timing)` once in each period until `stop` or the schedule's end.
///
/// A tick runs if its thread reaches it inside its period. A period that ends before that is
/// skipped, never made up in a burst, and counted by its cause:
///
///   late_wake_up  It ended while the thread slept.
///   stalled       It ended while the previous tick computed, whose wall time exceeded the thread's
///                 CPU time by more than half a period: the host took the core.
///   long_compute  It ended while the previous tick computed, otherwise.
///
/// The schedule is absolute, so lateness never accumulates. Periods beyond the end are not counted:
/// ticks + skipped is end_tick after a full run, and the number of elapsed periods after a stop.
///
/// The loop's own thread. Does not allocate. The clock makes the only system calls.
template <typename Body>
TickCount RunOnSchedule(const TickSchedule& schedule, std::stop_token stop, LoopClock& clock,
                        Body&& body) {
  const auto scheduled_at = [&](std::uint64_t tick) {
    return schedule.start_ns + static_cast<Nanoseconds>(tick) * schedule.period_ns;
  };
  // Number of whole periods from `tick` that are over at `now` (within the schedule).
  const auto missed_at = [&](std::uint64_t tick, Nanoseconds now) -> std::uint32_t {
    const Nanoseconds late = now - scheduled_at(tick);
    if (late < schedule.period_ns) return 0;
    const std::uint64_t missed = static_cast<std::uint64_t>(late / schedule.period_ns);
    const std::uint64_t left = schedule.end_tick - tick;
    return static_cast<std::uint32_t>(missed < left ? missed : left);
  };

  TickCount count;
  SkippedTicks skipped;  // since the last tick that ran
  std::uint32_t SkippedTicks::*cause = &SkippedTicks::late_wake_up;
  Nanoseconds now = clock.Now();
  std::uint64_t tick = 0;
  const auto skip = [&](std::uint32_t missed) {
    skipped.*cause += missed;
    count.skipped.*cause += missed;
    tick += missed;
  };

  while (tick < schedule.end_tick && !stop.stop_requested()) {
    if (now < scheduled_at(tick)) {
      clock.SleepUntil(scheduled_at(tick));
      now = clock.Now();
      cause = &SkippedTicks::late_wake_up;
    }
    if (const std::uint32_t missed = missed_at(tick, now); missed > 0) {
      skip(missed);
      continue;
    }
    const Nanoseconds woke = now;
    const Nanoseconds cpu_before = clock.ThreadCpuTime();
    body(tick, scheduled_at(tick), TickTiming{woke - scheduled_at(tick), skipped, &clock});
    ++count.ticks;
    ++tick;
    skipped = {};

    const Nanoseconds cpu = clock.ThreadCpuTime() - cpu_before;
    now = clock.Now();
    const bool stalled = now - woke - cpu > schedule.period_ns / 2;
    cause = stalled ? &SkippedTicks::stalled : &SkippedTicks::long_compute;
  }
  return count;
}

}  // namespace hpdm
