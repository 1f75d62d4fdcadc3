#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace hpdm {

/// Returns the units that the comment beside a member of an LCM type states: one for all values of
/// the member, or one for each of its `count` elements (empty where an element has none). Empty if
/// the comment states none.
///
///     "tip, world, m"                             m
///     "below the released surface, m; 0 if none"  m
///     "pitch (rad), yaw (rad), insertion (m)"     rad, rad, m; of 3 elements
///
/// Without a unit in the comment, a member whose name ends with _ns, _us, _s or _hz has that one.
std::vector<std::string> CommentUnits(std::string_view comment, std::string_view member,
                                      std::int64_t count);

}  // namespace hpdm
