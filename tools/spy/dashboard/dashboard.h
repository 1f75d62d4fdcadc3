#pragma once

#include "lcmtypes/wire/message_schema.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/dashboard/dashboard_server.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// Serves the dashboard of a live session or of a log until a signal ends it, and prints its
/// address. Throws MachineError if the port cannot be used. Main thread; construct `stop` before
/// any thread.
void ServeDashboard(const DashboardOptions& options, const MessageSchemas& schemas,
                    const StopSignals& stop, SpySource* source);

}  // namespace hpdm
