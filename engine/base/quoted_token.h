#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hpdm {

/// Quotes a token of a file for a message: cut to 24 bytes, bytes other than printable ASCII as
/// '?'.
inline std::string QuotedToken(std::string_view token, char quote = '\'') {
  constexpr std::size_t kMaxLength = 24;
  std::string text(1, quote);
  for (const char c : token.substr(0, kMaxLength)) text += (c >= ' ' && c <= '~') ? c : '?';
  if (token.size() > kMaxLength) text += "...";
  return text + quote;
}

}  // namespace hpdm
