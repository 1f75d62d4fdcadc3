#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "engine/threads/histogram.h"
#include "engine/threads/loop_schedule.h"
#include "engine/threads/realtime.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/telemetry/session_statistics.h"
#include "tools/replay/log_replay.h"
#include "tools/session/session.h"

namespace hpdm {

/// Results of a recording that ran in real time. Durations in the histograms are ns.
struct RealtimeReplay {
  TickCount haptic;
  TickCount deformation;
  SessionSummary session;                                        ///< Latencies and forces.
  std::uint64_t overflows = 0;                                   ///< Ticks without a measurement.
  std::vector<std::pair<std::string, RealtimeReport>> realtime;  ///< By thread.
  // For a log only:
  std::uint64_t compared = 0;  ///< Ticks that ran in both.
  std::array<ForceDifference, kMaxInstruments> forces;
};

/// Runs the production haptic and deformation threads on the session's own devices, switched on,
/// for `ticks` periods. `session` is used up. Main thread.
RealtimeReplay PlayInRealTime(std::uint64_t ticks, Session* session);

/// Plays a log in real time through the production haptic and deformation threads: the device
/// samples each in their own period, pauses and exchanges a few periods late. This machine times
/// the steps and patches, so the forces are close to the logged ones but not equal. A period that
/// is missing in the log keeps the previous sample. `session` is built from the log's scene and
/// used up. Throws InputError if the log is of another scene. Main thread; returns at the log's
/// end.
RealtimeReplay ReplayInRealTime(const LoggedSession& log, Session* session);

}  // namespace hpdm
