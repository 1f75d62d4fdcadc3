#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace hpdm {

/// Bytes as one line of UTF-8 that leads back to them: control characters and what is no UTF-8
/// become \xHH, a backslash two. Names of files may hold any byte; JSON, terminals and tables not.
std::string PathText(std::string_view bytes);

/// Bytes of the UTF-8 character that the text, which is not empty, begins with; 0 if it begins with
/// none.
std::size_t CharacterLength(std::string_view text);

}  // namespace hpdm
