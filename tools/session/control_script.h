#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/triple_buffer.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// What is asked of the haptic loop from a session time on.
struct TimedControl {
  Nanoseconds time_ns = 0;
  SessionControl control;
};

/// A trainee's wishes at known times, where nobody is there to have them. One thread, which writes
/// the edge.
class ControlScript {
 public:
  ControlScript() = default;
  /// Times that do not fall.
  explicit ControlScript(std::vector<TimedControl> wishes) : wishes_(std::move(wishes)) {}

  /// Tells the edge what holds at session time `now_ns`, which does not fall from call to call.
  void Advance(Nanoseconds now_ns, TripleBuffer<SessionControl>* edge);

 private:
  std::vector<TimedControl> wishes_;
  std::size_t next_ = 0;
};

/// The script of arguments NAME=OTHER@SECONDS: the hand whose first instrument is NAME takes OTHER,
/// one of its exchanges or NAME itself. Throws InputError for one that is not so.
ControlScript ParseExchanges(const std::vector<std::string>& arguments,
                             const std::vector<InstrumentOptions>& instruments);

}  // namespace hpdm
