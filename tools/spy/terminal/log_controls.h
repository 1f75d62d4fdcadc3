#pragma once

#include "lcmtypes/log/log_player.h"
#include "tools/spy/terminal/terminal_screen.h"

namespace hpdm {

/// Handles the keys for pause, speed and seeks. Returns false for other keys. Sets `sought` after a
/// seek.
bool HandleLogKey(int key, LogPlayer* player, bool* sought);

/// Draws the state of the playback: state, speed, position, a bar, length.
void DrawTimeLine(TerminalScreen* screen, int row, const LogPlayer& player);

}  // namespace hpdm
