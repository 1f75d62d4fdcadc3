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

/// What the threads of a run left behind.
struct RunRecord {
  bool interrupted = false;  ///< By a signal or in the window, before the asked time was over.
  bool lockstep = false;
  TickCount haptic;
  TickCount deformation;
  WakeUpBaseline baseline;                                       ///< Real clock only.
  std::optional<DeviceLinkSummary> link;                         ///< With external devices.
  std::vector<std::pair<std::string, RealtimeReport>> realtime;  ///< By thread.
};

/// summary.json: rates, percentiles, skipped ticks by cause, forces, the real-time state granted
/// and the machine's own wake-ups before the session; how the program was called (`command_line`,
/// its name first), by which machine, and what it read. `render` is null when nothing was drawn.
nlohmann::ordered_json RunSummary(const Session& session, const RunRecord& record,
                                  const TelemetrySummary& telemetry, const RenderLoop* render,
                                  const std::vector<std::string>& command_line,
                                  const SessionFolder& folder);

/// The same for people, a few lines.
std::string ReadableSummary(const nlohmann::ordered_json& summary);

}  // namespace hpdm
