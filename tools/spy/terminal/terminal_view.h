#pragma once

#include "lcmtypes/wire/message_schema.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// Shows the live view of `hpdm spy` on this terminal until the user or a signal ends it. Throws
/// MachineError if the terminal's type is unknown. Main thread.
///
/// Only the open channel is decoded. The figures change four times per second and the screen ten
/// times.
void RunTerminalView(SpySource* source, const MessageSchemas& schemas, const StopSignals& stop);

}  // namespace hpdm
