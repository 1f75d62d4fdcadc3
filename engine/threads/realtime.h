#pragma once

#include <optional>
#include <string>
#include <vector>

namespace hpdm {

/// Requests of a thread to the system before it starts its loop.
struct RealtimeOptions {
  std::optional<int> fifo_priority;  ///< SCHED_FIFO, 1..99; absent: the normal scheduler.
  bool lock_memory = false;          ///< The whole process, present and future pages.
  bool prefault_stack = false;       ///< Touch kPrefaultBytes of this thread's stack.
  /// Keep the processors out of deep idle states until the process ends; leaving one takes up to
  /// 100 us. Not requested if the system offers no such interface.
  bool keep_awake = false;
  /// Pin the thread to a core, counted from the last (0), since interrupts and other programs tend
  /// to the first. Not requested if the process may use only one or two cores. There pinning makes
  /// the loops wait for each other, and the scheduler does better.
  std::optional<int> core_from_last = {};
};

/// One request and its answer.
struct RealtimeGrant {
  bool asked = false;
  bool granted = false;
  std::string why_not;  ///< The system's reason and a remedy; empty if granted.
};

struct RealtimeReport {
  RealtimeGrant fifo;
  RealtimeGrant locked_memory;
  RealtimeGrant prefaulted_stack;
  RealtimeGrant pinned;
  RealtimeGrant kept_awake;
  int fifo_priority = 0;  ///< Granted, 0 without.
  int core = -1;          ///< Pinned to, -1 without.

  /// True if every request was granted.
  bool Complete() const { return FirstRefusal().empty(); }
  /// Returns the line of the first refused request; empty if complete.
  std::string FirstRefusal() const;
  /// Returns one line per request: "SCHED_FIFO 80: granted", "locked memory: refused (...)".
  std::vector<std::string> Lines() const;
};

/// Stack that is touched before a loop starts. The deformation loop's largest frames add up to 500 KiB.
inline constexpr int kPrefaultBytes = 1024 * 1024;

/// Makes the requests in `options`, each independently, and reports the answers.
///
/// - Requests are for the calling thread; memory and idle states are for the process. The first
///   call that asks for these two makes the request, and later calls report the same answer.
/// - Soft resource limits are raised to the hard ones if that helps.
/// - Memory is not locked under a finite limit, where every later allocation could fail.
/// - The thread's timer slack becomes 1 ns, which needs no rights.
///
/// Set-up only: allocates and makes system calls. Any thread; never throws.
RealtimeReport RequestRealtime(const RealtimeOptions& options) noexcept;

}  // namespace hpdm
