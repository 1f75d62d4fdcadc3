#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hpdm {

/// Escapes bytes into one reversible line of UTF-8: control characters and invalid UTF-8 become
/// \xHH, a backslash becomes two. File names may hold any byte; JSON, terminals and tables may not.
std::string PathText(std::string_view bytes);

/// Returns the length in bytes of the first UTF-8 character of `text`, which is not empty; 0 if it
/// is invalid.
std::size_t CharacterLength(std::string_view text);

}  // namespace hpdm
