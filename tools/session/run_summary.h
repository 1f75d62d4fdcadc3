#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/handling_limits.h"
#include "engine/threads/loop_schedule.h"
#include "engine/threads/realtime.h"
#include "engine/threads/wake_up_baseline.h"
#include "lcmtypes/live/device_link.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "render/render_loop.h"
#include "tools/session/session.h"
#include "tools/session/session_folder.h"

namespace hpdm {

/// Results of the threads of a run.
struct RunRecord {
  bool ended_by_exercise = false;  ///< By the end of the scene's exercise.
  bool ended_by_user = false;      ///< By a signal or in the window, before its length was over.
  bool lockstep = false;
  TickCount haptic;
  TickCount deformation;
  WakeUpBaseline baseline;                                       ///< Real clock only.
  std::optional<DeviceLinkSummary> link;                         ///< With external devices.
  std::vector<std::pair<std::string, RealtimeReport>> realtime;  ///< By thread.
};

/// Returns the content of summary.json:
///   - rates, percentiles, skipped ticks by cause and forces;
///   - the real-time state granted, and the machine's own wake-ups before the session;
///   - the command line (`command_line`, the program's name first), the machine, and the files that
///     were read.
/// `render` is null if nothing was drawn.
nlohmann::ordered_json RunSummary(const Session& session, const RunRecord& record,
                                  const TelemetrySummary& telemetry, const RenderLoop* render,
                                  const std::vector<std::string>& command_line,
                                  const SessionFolder& folder);

/// Returns what a person wants to know first, in four or five lines: time, peak force and depth of
/// each instrument with the limit that is below it, ticks missed if any, the folder, and the command
/// that reports on it. Losses of the log and of the picture have a line each. `program`: how hpdm
/// was called.
std::string BriefSummary(const nlohmann::ordered_json& summary, const std::string& folder,
                         const std::string& program, const HandlingLimits& limits = {});

/// Returns rates, latencies, forces, the log and the real-time state in lines for people.
std::string VerboseSummary(const nlohmann::ordered_json& summary);

}  // namespace hpdm
