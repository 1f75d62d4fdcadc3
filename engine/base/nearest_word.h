#pragma once

#include <span>
#include <string_view>

namespace hpdm {

/// Returns the known word that `word` most likely misspells, or "". At most a third of the known
/// word's letters, and at least one, may be inserted, deleted, replaced or swapped with the next.
std::string_view NearestWord(std::string_view word, std::span<const std::string_view> known);

}  // namespace hpdm
