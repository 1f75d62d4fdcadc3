#pragma once

#include <string>

#include "tools/spy/dashboard_server.h"

namespace hpdm {

/// `hpdm spy [LOG] --web`: serves the dashboard of the live session on NetworkUrl(), or of a log,
/// until SIGINT or SIGTERM. Throws InputError where the log cannot be read and MachineError where
/// no network or no port lets it. Main thread, before any other.
void RunDashboard(const std::string& log, const DashboardOptions& options);

}  // namespace hpdm
