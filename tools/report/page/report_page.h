#pragma once

#include <string>

#include "tools/report/metrics/session_files.h"
#include "tools/report/metrics/session_metrics.h"

namespace hpdm {

/// Returns a self-contained HTML page about a session: tables, which need no script, and the data
/// that the page's script draws. `against`: another session to compare with, or null.
std::string ReportPageText(const SessionReading& reading, const SessionFiles& files,
                           const SessionReport* against = nullptr);

}  // namespace hpdm
