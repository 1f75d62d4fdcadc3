#pragma once

#include <signal.h>

#include <array>

namespace hpdm {

/// Notices SIGINT (Ctrl-C) and SIGTERM while it lives, so that a command can end in its own way.
/// The second such signal ends the program at once. A signal that is ignored, as in a script's
/// background, stays ignored. One at a time, main thread.
class Interrupt {
 public:
  Interrupt();
  ~Interrupt();
  Interrupt(const Interrupt&) = delete;
  Interrupt& operator=(const Interrupt&) = delete;

  bool Requested() const;

 private:
  std::array<struct sigaction, 2> before_;
};

/// Exit code of a command that a user interrupted, as of a program that SIGINT ended.
inline constexpr int kInterruptedExitCode = 130;

}  // namespace hpdm
