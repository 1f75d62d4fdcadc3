#pragma once

#include <string>
#include <string_view>

#include "tools/report/session_files.h"
#include "tools/report/session_metrics.h"

namespace hpdm {

/// Text between tags and in quoted attributes: & < > " ' are replaced, other control characters and
/// what is not UTF-8 become U+FFFD. So no name from a log can be read as HTML.
std::string EscapeHtml(std::string_view text);

/// JSON for the inside of a <script>: nothing in it ends the script or opens a comment.
std::string EscapeScript(const std::string& json);

/// One self-contained HTML page about a session: tables that need no script, and the data that the
/// page's script draws. `against`: another session beside whose figures this one's stand, or null.
std::string ReportPageText(const SessionReading& reading, const SessionFiles& files,
                           const SessionReport* against = nullptr);

}  // namespace hpdm
