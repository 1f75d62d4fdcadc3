#pragma once

#include <chrono>

#include "lcmtypes/log/log.h"

namespace hpdm {

/// Source of LCM messages: a network (live_source.h) or a log that is played (log_player.h). One
/// thread.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// Waits at most `patience` for the next message. False if none came; ended() states whether any
  /// can still come. `event` keeps its memory. Its time stamp is the arrival (live) or the log's.
  virtual bool Next(LogEvent* event, std::chrono::milliseconds patience) = 0;

  /// True if no more messages will come: the end of a log.
  virtual bool ended() const { return false; }
};

}  // namespace hpdm
