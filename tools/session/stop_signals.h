#pragma once

#include <signal.h>

namespace hpdm {

/// SIGINT, SIGTERM and SIGHUP (the terminal was closed), which request a clean end. Construct it
/// before any thread, so that all threads inherit the blocked signals and only the main thread
/// receives them. A SIGHUP that is ignored, as under nohup, stays ignored.
class StopSignals {
 public:
  StopSignals() {
    sigemptyset(&signals_);
    sigaddset(&signals_, SIGINT);
    sigaddset(&signals_, SIGTERM);
    struct sigaction hangup = {};
    sigaction(SIGHUP, nullptr, &hangup);
    if (hangup.sa_handler != SIG_IGN) sigaddset(&signals_, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &signals_, nullptr);
  }
  /// Waits for a signal for less than a second; true if one came. Main thread.
  bool WaitFor(long nanoseconds) const { return SignalWithin(nanoseconds) > 0; }
  /// Waits as WaitFor does; returns the signal, or a number below 1. One thread at a time.
  int SignalWithin(long nanoseconds) const {
    const timespec wait = {0, nanoseconds};
    return sigtimedwait(&signals_, nullptr, &wait);
  }

 private:
  sigset_t signals_;
};

}  // namespace hpdm
