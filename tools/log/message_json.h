#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// LCM messages as JSON, and their types as JSON schemas, for programs without LCM.
///
///   integers   all digits; a reader whose numbers are doubles rounds those beyond 2^53
///   reals      the shortest text that reads back as the same double; NaN and infinities are the
///              strings "NaN", "Infinity" and "-Infinity" (as in protobuf's JSON)
///   booleans   true for any value but 0
///   arrays     several dimensions become one, row by row, because Foxglove reads no nested arrays;
///              the schema's description has the shape
///   text       bytes that are not UTF-8 become U+FFFD

/// Members that most types have, one integer each.
struct MessageHeader {
  std::optional<std::int64_t> sequence;
  std::optional<std::int64_t> time_ns;
};

/// Writes one message as JSON text on one line. Returns false if the bytes are not exactly one
/// message of the type; `json` and `header` are then undefined. Reuses memory.
bool MessageToJson(const MessageSchemas& schemas, const LcmStruct& type,
                   std::span<const std::uint8_t> bytes, std::string* json, MessageHeader* header);

/// Returns the JSON schema of MessageToJson's output for the type. A struct nested in itself has no
/// properties there.
std::string JsonSchemaOf(const MessageSchemas& schemas, const LcmStruct& type);

/// Returns the text with all bytes that are not UTF-8 replaced by U+FFFD.
std::string Utf8(const std::string& text);

}  // namespace hpdm
