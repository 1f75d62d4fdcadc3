#include "tools/run/set_up_progress.h"

#include <unistd.h>

#include <cstdio>

#include "engine/base/error.h"

namespace hpdm {

SetUpProgress::SetUpProgress(bool quiet)
    : quiet_(quiet), terminal_(!quiet && isatty(STDERR_FILENO) != 0) {}

void SetUpProgress::Say(const std::string& what) {
  if (quiet_) return;
  const std::string line = "preparing " + OneLine(what);
  if (terminal_) {
    std::fprintf(stderr, "\r\x1b[K%s, Ctrl-C ends", line.c_str());
    shown_ = true;
  } else {
    std::fprintf(stderr, "hpdm: %s\n", line.c_str());
  }
}

void SetUpProgress::Clear() {
  if (shown_) std::fprintf(stderr, "\r\x1b[K");
  shown_ = false;
}

}  // namespace hpdm
