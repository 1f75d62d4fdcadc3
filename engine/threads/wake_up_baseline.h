#pragma once

#include <stop_token>

#include "engine/threads/histogram.h"
#include "engine/threads/loop_schedule.h"

namespace hpdm {

/// Wake-up lateness of an empty loop on this machine. The rest of a session's lateness is the
/// program's own.
struct WakeUpBaseline {
  TickCount count;
  Histogram wake_late;  ///< ns.
};

/// Runs an empty loop on `schedule` in the calling thread and records its wake-ups. The thread
/// should have the real-time state of the loop to compare with. See RunOnSchedule.
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
