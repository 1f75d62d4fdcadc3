#pragma once

#include <stop_token>

#include "engine/threads/histogram.h"
#include "engine/threads/loop_schedule.h"

namespace hpdm {

/// How late the machine wakes a loop that has nothing to do: what remains of a session's lateness
/// beyond it is the program's.
struct WakeUpBaseline {
  TickCount count;
  Histogram wake_late;  ///< ns.
};

/// Runs an empty loop on `schedule` and records its wake-ups. The calling thread, which should have
/// the real-time state of the loop that the baseline is for; as RunOnSchedule.
inline WakeUpBaseline MeasureWakeUps(const TickSchedule& schedule, std::stop_token stop,
                                     LoopClock& clock) {
  WakeUpBaseline baseline;
  baseline.count = RunOnSchedule(
      schedule, stop, clock, [&](std::uint64_t, Nanoseconds, const TickTiming& timing) {
        baseline.wake_late.Add(
            WakeUpLateness(timing.wake_late_ns, timing.skipped, schedule.period_ns));
      });
  return baseline;
}

}  // namespace hpdm
