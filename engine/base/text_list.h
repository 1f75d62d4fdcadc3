#pragma once

#include <string>
#include <string_view>

namespace hpdm {

/// Appends an item to a list in a text: "a", then "a, b", then "a, b, c".
inline void AppendToList(std::string_view item, std::string* list,
                         std::string_view separator = ", ") {
  if (!list->empty()) list->append(separator);
  list->append(item);
}

}  // namespace hpdm
