#pragma once

#include <vector>

#include "render/overlay/status_text.h"

namespace hpdm {

/// Returns the page that the key F1 shows: the keys and what they do, and the instruments of the active
/// hand in the order of their exchange.
std::vector<StatusLine> HelpPage(const Status& status, const StatusNames& names);

}  // namespace hpdm
