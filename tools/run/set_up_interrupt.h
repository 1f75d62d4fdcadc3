#pragma once

#include <string_view>
#include <thread>

#include "tools/session/stop_signals.h"

namespace hpdm {

/// While this lives, a signal of StopSignals ends the program at once with exit code 128 + its
/// number (130 after Ctrl-C), whatever the main thread computes. For a set-up that has written
/// nothing yet and has no forces on: no destructor runs. A later signal waits for its StopSignals.
class SetUpInterrupt {
 public:
  static constexpr int kExitCode = 130;  ///< As a shell reports a program that SIGINT ended.
  static constexpr std::string_view kText =
      "hpdm: ended during the preparation; no session was begun\n";

  explicit SetUpInterrupt(const StopSignals& signals);

 private:
  std::jthread watcher_;  // asks to stop and joins, which takes at most 50 ms
};

}  // namespace hpdm
