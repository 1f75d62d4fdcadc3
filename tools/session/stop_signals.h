#pragma once

#include <signal.h>

namespace hpdm {

/// SIGINT, SIGTERM and SIGHUP (the terminal was closed), which ask for a clean end. They are
/// blocked before any thread is started, which inherits that, and taken by the main thread alone. A
/// SIGHUP that is ignored, as under nohup, stays so.
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
  /// True when one came within the time (less than a second). Main thread.
  bool WaitFor(long nanoseconds) const {
    const timespec wait = {0, nanoseconds};
    return sigtimedwait(&signals_, nullptr, &wait) > 0;
  }

 private:
  sigset_t signals_;
};

}  // namespace hpdm
