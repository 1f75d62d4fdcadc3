#include "engine/threads/realtime.h"

#include <fcntl.h>
#include <linux/capability.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

namespace hpdm {
namespace {

std::string Reason(int error, const char* remedy) {
  return std::string(std::strerror(error)) + "; " + remedy;
}

/// Raises the soft limit to the hard one. Returns the resulting limit.
rlim_t RaiseLimit(__rlimit_resource resource) {
  rlimit limit;
  if (getrlimit(resource, &limit) != 0) return 0;
  if (limit.rlim_cur != limit.rlim_max) {
    rlimit raised = limit;
    raised.rlim_cur = limit.rlim_max;
    if (setrlimit(resource, &raised) == 0) limit = raised;
  }
  return limit.rlim_cur;
}

/// True if this process may lock memory beyond its limit.
bool HasLockCapability() {
  __user_cap_header_struct header = {_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {};
  if (syscall(SYS_capget, &header, data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

RealtimeGrant LockMemory() {
  RealtimeGrant grant{.asked = true, .granted = false, .why_not = {}};
  const char* remedy = "raise it with `ulimit -l unlimited` or grant CAP_IPC_LOCK";
  const rlim_t limit = RaiseLimit(RLIMIT_MEMLOCK);
  if (limit != RLIM_INFINITY && !HasLockCapability()) {
    grant.why_not = "the limit of locked memory is " + std::to_string(limit / 1024) + " kB; " +
                    std::string(remedy);
  } else if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
    grant.why_not = Reason(errno, remedy);
  } else {
    grant.granted = true;
  }
  return grant;
}

const RealtimeGrant& LockMemoryOnce() {
  static const RealtimeGrant grant = LockMemory();
  return grant;
}

// The request (a latency of 0 us) holds while the file is open: until the process ends.
RealtimeGrant KeepAwake() {
  RealtimeGrant grant{.asked = true, .granted = false, .why_not = {}};
  const int file = open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC);
  if (file < 0 && errno == ENOENT) {
    grant.asked = false;
    grant.why_not = "the system has no /dev/cpu_dma_latency";
    return grant;
  }
  const std::int32_t latency_us = 0;
  grant.granted = file >= 0 && write(file, &latency_us, sizeof latency_us) == sizeof latency_us;
  if (!grant.granted) {
    grant.why_not = Reason(errno, "let this user write to /dev/cpu_dma_latency");
    if (file >= 0) close(file);
  }
  return grant;
}

const RealtimeGrant& KeepAwakeOnce() {
  static const RealtimeGrant grant = KeepAwake();
  return grant;
}

RealtimeGrant SetFifo(int priority) {
  RealtimeGrant grant{.asked = true, .granted = false, .why_not = {}};
  RaiseLimit(RLIMIT_RTPRIO);
  sched_param parameters{};
  parameters.sched_priority = priority;
  const int error = pthread_setschedparam(pthread_self(), SCHED_FIFO, &parameters);
  grant.granted = error == 0;
  if (error != 0) {
    grant.why_not =
        Reason(error, error == EINVAL ? "choose a priority of 1 to 99"
                                      : "raise it with `ulimit -r 99` or grant CAP_SYS_NICE");
  }
  return grant;
}

/// Writes to every page of its own frame. It is not inlined, so that the frame lies below the
/// caller's and is released at once.
// Touches that much of the stack, a frame at a time.
[[gnu::noinline]] void PrefaultStack(int bytes) {
  constexpr int kFrame = 128 * 1024;
  char frame[kFrame];
  volatile char* pages = frame;
  const long page = std::max(sysconf(_SC_PAGESIZE), 1L);
  for (long i = 0; i < kFrame; i += page) pages[i] = 0;
  if (bytes > kFrame) PrefaultStack(bytes - kFrame);
  pages[kFrame - 1] = 0;
}

RealtimeGrant Pin(int from_last, int* core) {
  RealtimeGrant grant{.asked = true, .granted = false, .why_not = {}};
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  if (sched_getaffinity(getpid(), sizeof allowed, &allowed) != 0) {
    grant.why_not = Reason(errno, "run without a core");
    return grant;
  }
  std::vector<int> cores;
  for (int c = CPU_SETSIZE - 1; c >= 0; --c) {
    if (CPU_ISSET(c, &allowed)) cores.push_back(c);
  }
  if (cores.size() <= 2) {
    grant.asked = false;
    grant.why_not = "only " + std::to_string(cores.size()) + " cores";
    return grant;
  }
  if (from_last < 0 || static_cast<std::size_t>(from_last) >= cores.size()) {
    grant.why_not = "no such core among " + std::to_string(cores.size());
    return grant;
  }
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(cores[from_last], &one);
  const int error = pthread_setaffinity_np(pthread_self(), sizeof one, &one);
  grant.granted = error == 0;
  if (error == 0) {
    *core = cores[from_last];
  } else {
    grant.why_not = Reason(error, "run without a core");
  }
  return grant;
}

std::string Line(std::string what, const RealtimeGrant& grant) {
  what += !grant.asked ? ": not asked for" : grant.granted ? ": granted" : ": refused";
  if (!grant.why_not.empty()) what.append(" (").append(grant.why_not).append(")");
  return what;
}

}  // namespace

std::string RealtimeReport::FirstRefusal() const {
  const RealtimeGrant* grants[] = {&fifo, &locked_memory, &prefaulted_stack, &pinned, &kept_awake};
  const std::vector<std::string> lines = Lines();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (grants[i]->asked && !grants[i]->granted) return lines[i];
  }
  return "";
}

std::vector<std::string> RealtimeReport::Lines() const {
  std::string scheduler = "SCHED_FIFO";
  if (fifo.granted) scheduler.append(" ").append(std::to_string(fifo_priority));
  std::string pin = "core";
  if (pinned.granted) pin.append(" ").append(std::to_string(core));
  return {Line(scheduler, fifo), Line("locked memory", locked_memory),
          Line("pre-faulted stack", prefaulted_stack), Line(pin, pinned),
          Line("no deep idle", kept_awake)};
}

RealtimeReport RequestRealtime(const RealtimeOptions& options) noexcept {
  RealtimeReport report;
  prctl(PR_SET_TIMERSLACK, 1, 0, 0, 0);
  if (options.lock_memory) report.locked_memory = LockMemoryOnce();
  if (options.keep_awake) report.kept_awake = KeepAwakeOnce();
  if (options.prefault_stack) {
    PrefaultStack(kPrefaultBytes);
    report.prefaulted_stack = {.asked = true, .granted = true, .why_not = {}};
  }
  if (options.core_from_last) report.pinned = Pin(*options.core_from_last, &report.core);
  if (options.fifo_priority) {
    report.fifo = SetFifo(*options.fifo_priority);
    if (report.fifo.granted) report.fifo_priority = *options.fifo_priority;
  }
  return report;
}

}  // namespace hpdm
