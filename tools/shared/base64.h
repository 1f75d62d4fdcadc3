#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace hpdm {

/// Bytes as RFC 4648 writes them in text, for what a page reads with atob().
inline std::string Base64(std::span<const std::byte> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<std::uint32_t>(bytes[i + k]) : 0);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      text += i + k <= bytes.size() ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

/// Of numbers as they lie in memory (little-endian, as typed arrays of a page read them).
template <typename Numbers>
std::string Base64Of(const Numbers& numbers) {
  return Base64(std::as_bytes(std::span(numbers.data(), static_cast<std::size_t>(numbers.size()))));
}

}  // namespace hpdm
