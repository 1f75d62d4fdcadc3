#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Returns the types of one .lcm text, without their hashes and the indices of inner structs.
/// `place` names the text in error messages. Throws InputError (place, line, fault, remedy).
std::vector<LcmStruct> ParseLcmTypes(std::string_view text, const std::string& place);

}  // namespace hpdm
