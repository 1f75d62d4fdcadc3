#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "engine/base/format.h"
#include "render/overlay/status_text.h"

/// Helpers that the parts of the status text share.
namespace hpdm {

/// Bytes of a line of the guidance: more would reach into the blocks of the instruments; and of those blocks.
inline constexpr std::size_t kGuidanceLine = 36, kToolLine = 26;

/// Adds a text in lines of up to about `most` bytes.
inline void AddWrapped(const std::string& text, Tone tone, std::vector<StatusLine>* lines,
                       std::size_t most = kGuidanceLine) {
  for (std::size_t begin = 0; begin < text.size();) {
    std::size_t end = text.size();
    if (end - begin > most) {
      const std::size_t space = text.rfind(' ', begin + most);
      end = space == std::string::npos || space <= begin ? text.find(' ', begin + most) : space;
      end = std::min(end, text.size());
    }
    lines->push_back({text.substr(begin, end - begin), tone});
    begin = end + 1;
  }
}

/// Returns the name of an instrument that a hand can hold; without one its number.
inline std::string InstrumentName(const StatusNames& names, int tool, int instrument_index) {
  const auto t = static_cast<std::size_t>(tool), e = static_cast<std::size_t>(instrument_index);
  if (t < names.instruments.size() && e < names.instruments[t].size()) {
    return names.instruments[t][e];
  }
  return Format("instrument %d", tool + 1);
}

/// Returns a hand's instruments in the order of their exchange, `marked` in brackets: "hook >
/// [clip applier] > scissors". A hand with one instrument gives its name.
inline std::string ExchangeOrder(const StatusNames& names, int tool, int marked) {
  const auto t = static_cast<std::size_t>(tool);
  const std::size_t count = t < names.instruments.size() ? names.instruments[t].size() : 0;
  if (count < 2) return InstrumentName(names, tool, marked);
  std::string text;
  for (std::size_t e = 0; e < count; ++e) {
    const bool is_marked = static_cast<int>(e) == marked;
    text += (e == 0 ? "" : " > ") +
            (is_marked ? "[" + names.instruments[t][e] + "]" : names.instruments[t][e]);
  }
  return text;
}

}  // namespace hpdm
