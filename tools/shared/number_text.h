#pragma once

#include <charconv>
#include <string_view>
#include <system_error>

namespace hpdm {

/// Reads `text` as one number, independent of the locale. Returns false unless the whole text is a
/// number.
template <typename Number>
bool ReadNumber(std::string_view text, Number* number) {
  if (text.starts_with('+')) text.remove_prefix(1);
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), *number);
  return error == std::errc() && end == text.data() + text.size();
}

}  // namespace hpdm
