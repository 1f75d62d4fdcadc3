#pragma once

#include <string>
#include <string_view>

#include "engine/base/format.h"

namespace hpdm {

/// Makes text from a message or a log safe to print: each control or non-ASCII byte becomes '?'.
inline std::string Printable(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return result;
}

/// Returns a duration in a readable unit.
inline std::string Duration(double us) {
  if (us < 99.5) return Format("%.3g us", us);
  if (us < 999.5) return Format("%.0f us", us);
  if (us < 999.5e3) return Format("%.3g ms", us / 1e3);
  return Format("%.3g s", us / 1e6);
}

/// Returns the number as 1,234,567.
inline std::string WithCommas(long long number) {
  const std::string digits = std::to_string(number < 0 ? -number : number);
  std::string text = number < 0 ? "-" : "";
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ',';
    text += digits[i];
  }
  return text;
}

}  // namespace hpdm
