#pragma once

#include <vector>

#include "render/overlay/status_text.h"

namespace hpdm {

/// Returns the lines about an instrument: its name, what it does, how far its target is, how a clip would
/// lie, and its force. Without what is next while the guidance is off. Any thread; allocates.
std::vector<StatusLine> ToolLines(const Status& status, const StatusNames& names, int tool);

}  // namespace hpdm
