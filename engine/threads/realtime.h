#pragma once

#include <optional>
#include <string>
#include <vector>

namespace hpdm {

/// What a thread asks of the system before it starts its loop.
struct RealtimeOptions {
  std::optional<int> fifo_priority;  ///< SCHED_FIFO, 1..99; absent: the normal scheduler.
  bool lock_memory = false;          ///< Of the whole process, present and future pages.
  bool prefault_stack = false;       ///< Touch kPrefaultBytes of this thread's stack.
  /// Keep the machine's processors out of their deep idle states until the process ends: leaving
  /// one takes up to some 100 us. Not asked for where the system offers no such promise.
  bool keep_awake = false;
  /// Pin to a core, where the process may use more than two (else reported as not asked for): 0 the
  /// last one, 1 the one before, and so on, since interrupts and other programs tend to the first.
  /// On one or two cores pinning would make the loops wait for each other, and the scheduler does
  /// better.
  std::optional<int> core_from_last = {};
};

/// One request and its answer.
struct RealtimeGrant {
  bool asked = false;
  bool granted = false;
  std::string why_not;  ///< The system's reason and a remedy; empty when granted.
};

struct RealtimeReport {
  RealtimeGrant fifo;
  RealtimeGrant locked_memory;
  RealtimeGrant prefaulted_stack;
  RealtimeGrant pinned;
  RealtimeGrant kept_awake;
  int fifo_priority = 0;  ///< Granted, 0 without.
  int core = -1;          ///< Pinned to, -1 without.

  /// Everything asked for was granted.
  bool Complete() const { return FirstRefusal().empty(); }
  /// The line of the first request that was refused; empty when complete.
  std::string FirstRefusal() const;
  /// One line a request: "SCHED_FIFO 80: granted", "locked memory: refused (...)".
  std::vector<std::string> Lines() const;
};

/// Stack that is touched before a loop starts, far above what a loop's calls need.
inline constexpr int kPrefaultBytes = 256 * 1024;

/// Asks for the calling thread (memory: for the process) what `options` name, each independently of
/// the others, and reports what was granted. Soft resource limits are raised to the hard ones where
/// that helps. Memory is locked and idle states are forbidden by the first call that asks, and
/// later calls report the same answer; memory is not locked under a finite limit, where every later
/// allocation could fail. Also takes the thread's timer slack down to 1 ns, which needs no rights.
/// For set-up: it allocates and makes system calls. Never throws; any thread.
RealtimeReport RequestRealtime(const RealtimeOptions& options) noexcept;

}  // namespace hpdm
