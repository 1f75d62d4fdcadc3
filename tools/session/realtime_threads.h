#pragma once

#include "engine/threads/realtime.h"

namespace hpdm {

/// Real-time settings that the process and the threads of a session request before they start.
inline RealtimeOptions ProcessRealtime() {
  RealtimeOptions options;
  options.lock_memory = true;
  options.keep_awake = true;
  return options;
}
inline RealtimeOptions HapticRealtime() {
  return {.fifo_priority = 80, .prefault_stack = true, .core_from_last = 0};
}
inline RealtimeOptions DeformationRealtime() {
  return {.fifo_priority = 40, .prefault_stack = true, .core_from_last = 1};
}

}  // namespace hpdm
