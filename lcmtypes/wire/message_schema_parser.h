#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// The types of one .lcm text, without their hashes and the places of the structs inside. `place`
/// stands for the text in messages. Throws InputError (place, line, what, remedy).
std::vector<LcmStruct> ParseLcmTypes(std::string_view text, const std::string& place);

}  // namespace hpdm
