#pragma once

#include <chrono>

#include "lcmtypes/log/log.h"

namespace hpdm {

/// Where LCM messages come from: a network as they arrive (live_source.h), or a log as it was
/// played (log_player.h). One thread.
class MessageSource {
 public:
  virtual ~MessageSource() = default;

  /// Waits at most `patience` for the next message. False: none came; ended() tells whether any
  /// can. `event` keeps its memory; its time stamp is the arrival's (live) or the log's.
  virtual bool Next(LogEvent* event, std::chrono::milliseconds patience) = 0;

  /// Nothing more will come: the end of a log.
  virtual bool ended() const { return false; }
};

}  // namespace hpdm
