#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

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
  bool interrupted = false;  ///< Ended early by a signal or in the window.
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

/// Returns the same in a few lines for people.
std::string ReadableSummary(const nlohmann::ordered_json& summary);

}  // namespace hpdm
