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

/// Cuts a text to at most `max_bytes` and "...", between two characters (UTF-8).
inline std::string Shortened(std::string_view text, std::size_t max_bytes) {
  if (text.size() <= max_bytes) return std::string(text);
  std::size_t end = max_bytes;
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  return std::string(text.substr(0, end)) + "...";
}

inline constexpr std::size_t kMaxQuoted = 60;  ///< Bytes.

/// Quotes a text for a message. Only cuts it to kMaxQuoted bytes; InputError escapes the rest.
inline std::string Quoted(std::string_view text) { return '"' + Shortened(text, kMaxQuoted) + '"'; }

}  // namespace hpdm
