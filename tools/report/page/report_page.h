#pragma once

#include <string>

#include "tools/report/metrics/session_files.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// One self-contained HTML page about a session: tables that need no script, and the data that the
/// page's script draws. `against`: another session beside whose figures this one's stand, or null.
std::string ReportPageText(const SessionReading& reading, const SessionFiles& files,
                           const SessionReport* against = nullptr);

}  // namespace hpdm
