#pragma once

#include <string>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// The types of this package and those of the given .lcm files. Throws InputError where one cannot
/// be read or is no such file.
MessageSchemas SchemasWith(const std::vector<std::string>& files);

}  // namespace hpdm
