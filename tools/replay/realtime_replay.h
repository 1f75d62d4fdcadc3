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

/// How a recording ran in real time. Durations in the histograms are ns.
struct RealtimeReplay {
  TickCount haptic;
  TickCount deformation;
  SessionSummary session;                                        ///< Latencies and forces.
  std::uint64_t overflows = 0;                                   ///< Ticks that were not measured.
  std::vector<std::pair<std::string, RealtimeReport>> realtime;  ///< By thread.
  // Of a log:
  std::uint64_t compared = 0;  ///< Ticks that ran in both.
  std::array<ForceDifference, kMaxInstruments> forces;
};

/// Runs the production haptic and deformation threads on the session's own devices, switched on,
/// for `ticks` periods. `session` is used up. Main thread.
RealtimeReplay PlayInRealTime(std::uint64_t ticks, Session* session);

/// Plays the log's device samples in real time, each in its own period, its pauses and exchanges a
/// few periods late, through the production
/// haptic and deformation threads. Steps and patches fall as this machine makes them, so that the
/// forces are near the logged ones and not the same. A period that the log lacks holds the sample
/// before. `session` is built from the log's scene and used up. Throws InputError when the log is
/// of another scene. Main thread; returns when the log is over.
RealtimeReplay ReplayInRealTime(const LoggedSession& log, Session* session);

}  // namespace hpdm
