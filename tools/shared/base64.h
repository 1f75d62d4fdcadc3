#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace hpdm {

/// Returns bytes as base64 text (RFC 4648), which a page reads with atob().
std::string Base64(std::span<const std::byte> bytes);

/// Returns the base64 text of numbers as they are in memory: little-endian, as a page's typed
/// arrays.
template <typename Numbers>
std::string Base64Of(const Numbers& numbers) {
  return Base64(std::as_bytes(std::span(numbers.data(), static_cast<std::size_t>(numbers.size()))));
}

}  // namespace hpdm
