#pragma once

#include <time.h>

#include <cerrno>

#include "engine/base/types.h"

namespace hpdm {

/// Reads one of the system's clocks, ns. Wait-free.
inline Nanoseconds ReadClock(clockid_t clock) {
  timespec now;
  clock_gettime(clock, &now);
  return now.tv_sec * kNanosecondsPerSecond + now.tv_nsec;
}

/// Returns the CPU time of the calling thread, ns; only differences count. If wall time passes
/// without CPU time, something else had the core. Wait-free, one system call (0.2-0.5 us).
inline Nanoseconds ThreadCpuTime() { return ReadClock(CLOCK_THREAD_CPUTIME_ID); }

/// The real clock of a session: CLOCK_MONOTONIC since the clock's construction. Steps of the wall
/// clock do not affect it. It is constant after construction, so any number of threads may use it
/// or a copy. No function allocates, locks or throws.
class SessionClock {
 public:
  SessionClock() : start_(ReadClock(CLOCK_MONOTONIC)) {}

  /// Time since the session began. Wait-free, no system call (vDSO).
  Nanoseconds Now() const { return ReadClock(CLOCK_MONOTONIC) - start_; }

  /// Sleeps until Now() >= `time`; returns at once if that has passed. The sleep is absolute, so
  /// the lateness of one call does not add to the next; signals do not cut it short.
  void SleepUntil(Nanoseconds time) const {
    const Nanoseconds wake_up = start_ + time;
    if (wake_up <= 0) return;
    timespec at;
    at.tv_sec = wake_up / kNanosecondsPerSecond;
    at.tv_nsec = wake_up % kNanosecondsPerSecond;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
    }
  }

 private:
  Nanoseconds start_;
};

}  // namespace hpdm
