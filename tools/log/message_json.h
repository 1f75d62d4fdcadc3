#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// LCM messages as JSON, and their types as JSON schemas, for programs that know no LCM.
///
/// Integers keep all their digits; a reader whose numbers are doubles rounds those beyond 2^53.
/// Reals are the shortest text that reads back as the same double. NaN and infinities, which JSON
/// lacks, are the strings "NaN", "Infinity" and "-Infinity" (as in protobuf's JSON). Booleans are
/// true for any value but 0. Arrays of several dimensions become one, row by row (shape in the
/// schema's description), since Foxglove takes no nested arrays. Bytes that are no UTF-8 become
/// U+FFFD.

/// What most types tell of a message in members of these names, which are one integer each.
struct MessageHeader {
  std::optional<std::int64_t> sequence;
  std::optional<std::int64_t> time_ns;
};

/// The JSON text of one message, on one line. False when the bytes are not exactly one message of
/// the type; then neither `json` nor `header` holds anything of use. Reuses memory.
bool MessageToJson(const MessageSchemas& schemas, const LcmStruct& type,
                   std::span<const std::uint8_t> bytes, std::string* json, MessageHeader* header);

/// JSON Schema of what MessageToJson writes for the type. A struct within itself has no properties.
std::string JsonSchemaOf(const MessageSchemas& schemas, const LcmStruct& type);

/// The text with whatever is no UTF-8 in it replaced by U+FFFD.
std::string Utf8(const std::string& text);

}  // namespace hpdm
