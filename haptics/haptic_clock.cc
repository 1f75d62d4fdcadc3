#include "haptics/haptic_clock.h"

#include <cerrno>
#include <ctime>

namespace hpdm {
namespace {

Nanoseconds Read(clockid_t id) {
  timespec t;
  clock_gettime(id, &t);
  return t.tv_sec * kNanosecondsPerSecond + t.tv_nsec;
}

}  // namespace

Nanoseconds MonotonicHapticClock::Now() noexcept { return Read(CLOCK_MONOTONIC) - origin_ns_; }

Nanoseconds MonotonicHapticClock::ThreadCpuTime() noexcept { return Read(CLOCK_THREAD_CPUTIME_ID); }

void MonotonicHapticClock::SleepUntil(Nanoseconds time) noexcept {
  const Nanoseconds absolute = time + origin_ns_;
  const timespec t{.tv_sec = absolute / kNanosecondsPerSecond,
                   .tv_nsec = absolute % kNanosecondsPerSecond};
  // A signal handler that ran meanwhile is no reason to start early.
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace hpdm
