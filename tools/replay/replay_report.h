#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/telemetry/session_statistics.h"
#include "tools/replay/log_replay.h"
#include "tools/replay/realtime_replay.h"
#include "tools/session/session.h"

namespace hpdm {

/// Returns the report of a replay in the log's order of events, and its text for people.
nlohmann::ordered_json LogReplayReport(const LoggedSession& log, const Session& session,
                                       const LogReplay& replay);
std::string ReplayText(const LoggedSession& log, const LogReplay& replay,
                       const nlohmann::ordered_json& report);

/// Returns the report of a recording that ran in real time, and its text for people. `of_log`: the
/// recording is a log, whose forces are compared; a recorded motion has none.
nlohmann::ordered_json RealtimeReplayReport(const std::string& recording, const Session& session,
                                            const RealtimeReplay& replay, bool of_log);
std::string RealtimeText(const nlohmann::ordered_json& report);

/// Returns the forces and depths of each instrument, and their lines for people from a report's
/// "tools".
nlohmann::ordered_json FeltToJson(const Session& session, const SessionSummary& summary);
std::string ToolLines(const nlohmann::ordered_json& report);

}  // namespace hpdm
