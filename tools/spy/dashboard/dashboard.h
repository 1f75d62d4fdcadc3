#pragma once

#include "lcmtypes/wire/message_schema.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/dashboard/dashboard_server.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// `hpdm spy [LOG] --web`: serves the dashboard of a live session or of a log until a signal ends
/// it, and says where. Throws MachineError where no port lets it. Main thread; `stop` was made
/// before any other.
void ServeDashboard(const DashboardOptions& options, const MessageSchemas& schemas,
                    const StopSignals& stop, SpySource* source);

}  // namespace hpdm
