#pragma once

#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Returns the types of this package and of the given .lcm files. Throws InputError if a file
/// cannot be read or does not define types.
MessageSchemas SchemasWith(const std::vector<std::string>& files);

}  // namespace hpdm
