#pragma once

#include "lcmtypes/wire/message_schema.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// The live view of `hpdm spy` on this terminal, until the user or a signal ends it. Throws
/// MachineError where the terminal's type is not known. Main thread.
///
/// Only the channel that is open is decoded. The source is read every kFrame at most, in one go;
/// figures change four times, pictures ten times a second.
void RunTerminalView(SpySource* source, const MessageSchemas& schemas, const StopSignals& stop);

}  // namespace hpdm
