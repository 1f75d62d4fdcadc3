#pragma once

#include "lcmtypes/log/log_player.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// Pause, speed and seeks. False: the key is not for the log. `sought` becomes true when the events
/// to come do not follow those before.
bool HandleLogKey(int key, LogPlayer* player, bool* sought);

/// Where the play is: state, speed, position, a bar, length.
void DrawTimeLine(TerminalScreen* screen, int row, const LogPlayer& player);

}  // namespace hpdm
