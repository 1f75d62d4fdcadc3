#include "tools/run/set_up_interrupt.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

namespace hpdm {
namespace {

constexpr long kPatience = 50'000'000;  // ns

[[noreturn]] void EndProgram(int signal) {
  constexpr std::string_view kClearLine = "\r\x1b[K";
  [[maybe_unused]] ssize_t written = 0;
  if (isatty(STDERR_FILENO) != 0) {
    written = write(STDERR_FILENO, kClearLine.data(), kClearLine.size());
  }
  written = write(STDERR_FILENO, SetUpInterrupt::kText.data(), SetUpInterrupt::kText.size());
  std::_Exit(128 + signal);
}

}  // namespace

SetUpInterrupt::SetUpInterrupt(const StopSignals& signals)
    : watcher_([&signals](const std::stop_token& stop) {
        while (!stop.stop_requested()) {
          if (const int signal = signals.SignalWithin(kPatience); signal > 0) EndProgram(signal);
        }
      }) {}

}  // namespace hpdm
