#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <string_view>

namespace hpdm {

enum class EventSeverity : std::int8_t { kInfo = 0, kWarning = 1, kError = 2 };

/// A notable event in a loop, of fixed size: render loop -> telemetry loop, every one through a
/// queue.
struct LoopEvent {
  EventSeverity severity = EventSeverity::kInfo;
  std::array<char, 32> name{};   ///< Short and stable ("render.ended"), ends with a zero.
  std::array<char, 256> text{};  ///< One sentence, ends with a zero.
};

/// Returns an event; truncates the name and the text to their arrays.
inline LoopEvent MakeLoopEvent(EventSeverity severity, std::string_view name,
                               std::string_view text) {
  LoopEvent event;
  event.severity = severity;
  std::copy_n(name.begin(), std::min(name.size(), event.name.size() - 1), event.name.begin());
  std::copy_n(text.begin(), std::min(text.size(), event.text.size() - 1), event.text.begin());
  return event;
}

}  // namespace hpdm
