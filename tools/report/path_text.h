#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace hpdm {

/// Bytes as one line of UTF-8 that leads back to them: control characters and what is no UTF-8
/// become \xHH, a backslash two. Names of files may hold any byte; JSON, terminals and tables not.
std::string PathText(std::string_view bytes);

}  // namespace hpdm
