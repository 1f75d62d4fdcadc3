#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <span>
#include <string_view>

namespace hpdm {

/// A message begins with the hash of its type: 8 bytes, the high one first.
inline constexpr std::size_t kHashBytes = 8;

/// Returns the hash at a message's start, which must have at least kHashBytes bytes.
inline std::uint64_t HashOf(std::span<const std::uint8_t> bytes) {
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < kHashBytes; ++i) hash = hash << 8 | bytes[i];
  return hash;
}

/// A message type that had other field names in an earlier version. LCM hashes the names, so the
/// hash differs; the bytes behind it hold the same values in the same order.
struct FormerType {
  std::string_view name;   ///< Without its package: "tool_t".
  std::uint64_t hash = 0;  ///< Former hash.
};

/// Version 0.1's type that has the same bytes today. Its contact_t, force_t and tool_t have not.
inline constexpr FormerType kFormerTypes[] = {{"organ_t", 0xb5e787d510edf669}};

/// True if a message of at least kHashBytes bytes begins with a former hash of the type `name`.
inline bool HasFormerHash(std::span<const std::uint8_t> bytes, std::string_view name) {
  const std::uint64_t hash = HashOf(bytes);
  return std::any_of(std::begin(kFormerTypes), std::end(kFormerTypes), [&](const FormerType& type) {
    return type.hash == hash && type.name == name;
  });
}

}  // namespace hpdm
