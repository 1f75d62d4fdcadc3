#pragma once

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <string>
#include <string_view>

#include "lcmtypes/analysis/channel_table.h"
#include "tools/shared/report_text.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// True if `text` contains `part`, ignoring case.
inline bool HasInIt(std::string_view text, std::string_view part) {
  const auto same = [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  };
  return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end() ||
         part.empty();
}

/// Aligns text to the left of `width` columns. Text that is too long loses its end.
inline std::string FitLeft(std::string_view text, int width, const Glyphs& glyphs) {
  std::string result(text);
  if (WidthOf(text) > width) {
    result = std::string(text.substr(0, static_cast<std::size_t>(std::max(0, width - 1))));
    result += glyphs.ellipsis;
  }
  result.append(static_cast<std::size_t>(std::max(0, width - WidthOf(result))), ' ');
  return result;
}
/// As FitLeft, but text that is too long loses its beginning. ASCII only.
inline std::string FitLeftKeepingEnd(std::string_view text, int width, const Glyphs& glyphs) {
  if (WidthOf(text) <= width) return FitLeft(text, width, glyphs);
  const auto kept = static_cast<std::size_t>(std::max(0, width - 1));
  return std::string(glyphs.ellipsis) + std::string(text.substr(text.size() - kept));
}
/// Aligns text to the right of `width` columns.
inline std::string FitRight(std::string_view text, int width) {
  return std::string(static_cast<std::size_t>(std::max(0, width - WidthOf(text))), ' ') +
         std::string(text);
}

/// Formats a count in at most `width` columns: 1,234,567 or 1234567 or 1.2e+06.
inline std::string CountText(std::uint64_t count, int width) {
  std::string text = count <= INT64_MAX ? WithCommas(static_cast<long long>(count)) : "";
  if (text.empty() || WidthOf(text) > width) text = std::to_string(count);
  if (WidthOf(text) > width) text = Format("%.0e", static_cast<double>(count));
  return text;
}

/// Formats a number in at most `width` (>= 9) columns, with the digits that fit.
inline std::string NumberText(std::int64_t number, int width) {
  const std::string text = std::to_string(number);
  return WidthOf(text) <= width ? text : Format("%.*g", width - 7, static_cast<double>(number));
}
inline std::string NumberText(double number, int width) {
  return Format("%.*g", std::min(6, width - 7), number);
}

/// Formats a time since a log's start: 1:02.3, 1:02:03.4.
inline std::string TimeText(std::int64_t microseconds) {
  const std::int64_t tenths = microseconds / 100'000;
  const long long hours = tenths / 36'000;
  const int minutes = static_cast<int>(tenths / 600 % 60);
  const double seconds = 0.1 * static_cast<double>(tenths % 600);
  return hours > 0 ? Format("%lld:%02d:%04.1f", hours, minutes, seconds)
                   : Format("%d:%04.1f", minutes, seconds);
}

/// Formats the rate in Hz with four digits.
inline std::string RateText(const ChannelRow& row) {
  return row.flow.rate_hz > 0 ? Format("%.4g", row.flow.rate_hz) : "-";
}

/// Formats a duration that exists only after two messages.
inline std::string JitterText(double seconds, const ChannelRow& row) {
  return row.flow.rate_hz > 0 ? Duration(1e6 * seconds) : "-";
}

inline std::string BandwidthText(double bytes_per_s) {
  if (bytes_per_s <= 0) return "-";
  if (bytes_per_s < 999.5) return Format("%.3g B/s", bytes_per_s);
  if (bytes_per_s < 999.5e3) return Format("%.3g kB/s", bytes_per_s / 1e3);
  return Format("%.3g MB/s", bytes_per_s / 1e6);
}

}  // namespace hpdm
