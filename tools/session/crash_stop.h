#pragma once

#include "haptics/haptic_loop.h"

namespace hpdm {

/// Takes the forces of a haptic loop's devices away at once when the program crashes: on each
/// signal that would end it, which std::terminate, std::abort and HPDM_CHECK come to as well, and
/// on std::exit. The program then ends as it would have done. Signals that are ignored or have a
/// handler of their own keep that.
///
/// SIGKILL cannot be caught: a driver's watchdog ends the force then (haptics/README.md).
///
/// One at a time. Made and ended on the main thread, while the loop lives.
class CrashStop {
 public:
  explicit CrashStop(HapticLoop* loop);
  ~CrashStop();
  CrashStop(const CrashStop&) = delete;
  CrashStop& operator=(const CrashStop&) = delete;
};

}  // namespace hpdm
