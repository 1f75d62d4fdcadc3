#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Structs inside of structs. LCM permits recursive types; a message of one could nest as deep as
/// it is long.
inline constexpr std::size_t kMaxDepth = 64;

/// Goes through the bytes of a message of type `type`, one of `structs`. True when they are exactly
/// one such message. Tells `visitor` of its values and `order` of its place among others; each may
/// be null. Without a visitor names are not made and arrays of numbers are stepped over. Trusts no
/// length; its steps are in proportion to the bytes.
bool WalkMessage(const std::vector<LcmStruct>& structs, const LcmStruct& type,
                 std::span<const std::uint8_t> bytes, MessageVisitor* visitor, MessageOrder* order);

}  // namespace hpdm
