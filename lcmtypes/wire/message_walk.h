#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Most levels of structs inside structs. LCM permits recursive types; a message of one could nest
/// as deep as it is long.
inline constexpr std::size_t kMaxDepth = 64;

/// Walks through the bytes of a message of type `type`, one of `structs`. True if they are exactly
/// one such message. Passes its values to `visitor` and its position to `order`; each may be null.
/// Without a visitor no names are built and arrays of numbers are skipped. Trusts no length; the
/// cost is proportional to the bytes.
bool WalkMessage(const std::vector<LcmStruct>& structs, const LcmStruct& type,
                 std::span<const std::uint8_t> bytes, MessageVisitor* visitor, MessageOrder* order);

}  // namespace hpdm
