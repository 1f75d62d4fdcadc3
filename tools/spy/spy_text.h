#pragma once

#include <string>
#include <string_view>

#include "lcmtypes/channel_table.h"
#include "tools/report_text.h"

namespace hpdm {

/// A name or text from a message: what a terminal might obey, or does not show in one column a
/// byte, becomes '?'.
inline std::string Printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return result;
}

/// Hz, with four digits.
inline std::string RateText(const ChannelRow& row) {
  return row.flow.rate_hz > 0 ? Format("%.4g", row.flow.rate_hz) : "-";
}

/// A duration that needs two messages.
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
