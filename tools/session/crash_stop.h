#pragma once

#include "haptics/haptic_loop.h"

namespace hpdm {

/// Removes the forces of a haptic loop's devices when the program crashes or calls std::exit. It
/// handles each signal that would end the program; std::terminate, std::abort and HPDM_CHECK raise
/// one. The program then ends as it would without this class. Signals that are ignored or have
/// another handler are left alone.
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
