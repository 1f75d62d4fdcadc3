#include "tools/session/crash_stop.h"

#include <signal.h>

#include <atomic>
#include <cstdlib>

#include "engine/base/check.h"

namespace hpdm {
namespace {

// Signals that end a program by default. Not among them: SIGKILL; requests for a clean end
// (stop_signals.h); SIGPIPE and SIGXFSZ, which a session ignores.
constexpr int kSignals[] = {SIGABRT, SIGALRM, SIGBUS,    SIGFPE,  SIGILL, SIGIO,
                            SIGPROF, SIGPWR,  SIGQUIT,   SIGSEGV, SIGSYS, SIGTRAP,
                            SIGUSR1, SIGUSR2, SIGVTALRM, SIGXCPU};

// A handler has no other way to its loop.
std::atomic<HapticLoop*> loop_to_stop = nullptr;
static_assert(std::atomic<HapticLoop*>::is_always_lock_free);

void StopForces() {
  if (HapticLoop* loop = loop_to_stop) loop->EmergencyStop();
}

// The default action is back by now: the signal comes again, and ends the program, when this
// returns.
void StopForcesAndEnd(int signal) {
  StopForces();
  raise(signal);
}

bool HandledBy(int signal, void (*handler)(int)) {
  struct sigaction action = {};
  sigaction(signal, nullptr, &action);
  return (action.sa_flags & SA_SIGINFO) == 0 && action.sa_handler == handler;
}

}  // namespace

CrashStop::CrashStop(HapticLoop* loop) {
  HPDM_CHECK(loop_to_stop.exchange(loop) == nullptr);
  [[maybe_unused]] static const int registered = std::atexit(StopForces);
  struct sigaction action = {};
  action.sa_handler = StopForcesAndEnd;
  action.sa_flags = SA_RESETHAND | SA_ONSTACK;
  for (const int signal : kSignals) {
    if (HandledBy(signal, SIG_DFL)) sigaction(signal, &action, nullptr);
  }
}

CrashStop::~CrashStop() {
  for (const int signal : kSignals) {
    if (HandledBy(signal, StopForcesAndEnd)) ::signal(signal, SIG_DFL);
  }
  loop_to_stop = nullptr;
}

}  // namespace hpdm
