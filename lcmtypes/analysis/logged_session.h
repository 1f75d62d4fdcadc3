#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/telemetry_loop.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

/// One haptic tick as the log has it.
struct LoggedTick {
  HapticSample sample;
  bool has_output = false;  ///< False: HPDM_FORCE is missing, and with it what the tick gave.
  /// Ticks that ran since the one before but are not in the log (a full queue, damage).
  std::uint64_t lost_before = 0;
};

/// Reads the ticks of a log in order, damaged or not. One thread.
///
/// One flipped bit makes a tick's number anything, so a number that is not the next one (after the
/// periods that the tick says were skipped) is believed when another message says the same: the
/// tick's own output, or the tick right behind it. A tick whose number nothing confirms is dropped
/// and counted as unreadable; those after it count on from what was believed.
class TickReader {
 public:
  /// `visit` is given every event of every channel as it is read, before the tick it belongs to.
  /// Throws InputError where the file cannot be read.
  explicit TickReader(const std::string& path, std::function<void(const LogEvent&)> visit = nullptr)
      : reader_(path), visit_(std::move(visit)) {}

  /// The next tick that has its input; false at the end.
  bool Next(LoggedTick* tick);

  /// Messages of ticks so far that held nothing readable, or a tick that was over already.
  std::uint64_t unreadable() const { return unreadable_; }
  /// The file: its size and its damage so far.
  const LogReader& log() const { return reader_; }

 private:
  /// The number is the next one: nothing was lost before it.
  bool Expected(const HapticSample& sample) const;
  bool Finish(const HapticSample& sample, bool has_output, LoggedTick* tick);

  LogReader reader_;
  std::function<void(const LogEvent&)> visit_;
  LogEvent event_;
  tool_t tool_{};
  force_t force_{};
  std::optional<HapticSample> waiting_;  // an input whose output may follow
  std::uint64_t next_tick_ = 0;          // after the last one returned
  std::uint64_t unreadable_ = 0;
};

/// One deformation step as the log has it.
struct LoggedStep {
  StepSample sample;
  std::int64_t visible_tick = kNeverVisible;
};

/// All of a session's log but its ticks, which are many: see TickReader. Constant.
class LoggedSession {
 public:
  /// Reads the whole file. Throws InputError where it cannot be read or holds no session.
  explicit LoggedSession(const std::string& path);

  const std::string& path() const { return path_; }
  /// Steps 1, 2, 3 and so on, up to the first that is missing.
  const std::vector<LoggedStep>& steps() const { return steps_; }
  /// Steps in the log behind a missing one, of no use to a replay.
  std::uint64_t steps_unusable() const { return steps_unusable_; }
  /// The session was closed in an orderly way: the log has its end.
  bool closed() const { return closed_; }
  std::uint64_t damaged_stretches() const { return damaged_stretches_; }
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }

  /// Why this is no log of a session of `info`: other instruments, organs, lattices or meshes, as
  /// far as the log's intact parts tell; empty when it may be one. Coordinates may differ by a
  /// micrometre, since they are logged in float.
  std::string WhyAnother(const SessionInfo& info) const;

 private:
  std::string path_;
  std::string start_text_;
  std::vector<mesh_t> mesh_parts_;
  std::vector<LoggedStep> steps_;
  std::uint64_t steps_unusable_ = 0;
  bool closed_ = false;
  std::uint64_t damaged_stretches_ = 0;
  std::uint64_t damaged_bytes_ = 0;
};

}  // namespace hpdm
