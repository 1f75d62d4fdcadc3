#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/output_thinning.h"
#include "lcmtypes/telemetry/session_info.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

/// One haptic tick of a log.
struct LoggedTick {
  HapticSample sample;
  bool has_output = false;  ///< False if HPDM_FORCE, the tick's output, is not in the log.
  /// The output is missing although the log should hold it: a thinned one (output_thinning.h) holds
  /// that of the first tick of each interval.
  bool output_lost = false;
  /// Ticks between the previous one and this that ran but are not in the log (full queue, damage).
  std::uint64_t lost_before = 0;
};

/// Reads the ticks of a log in order, damaged or not. One thread.
///
/// A flipped bit can change a tick's number. So a number that is not the next one (after the
/// skipped periods that the tick states) must be confirmed by another message: the tick's own
/// output or the tick right behind it. An unconfirmed tick is dropped and counted as unreadable;
/// the following ones continue from the last accepted number.
class TickReader {
 public:
  /// `visit` is given every event of every channel as it is read, before the tick it belongs to.
  /// Throws InputError if the file cannot be read.
  explicit TickReader(const std::string& path, std::function<void(const LogEvent&)> visit = nullptr)
      : reader_(path), visit_(std::move(visit)) {}

  /// Reads the next tick whose input is in the log. Returns false at the end of the log.
  bool Next(LoggedTick* tick);

  /// Returns the number of tick messages so far that were unreadable or belonged to an earlier
  /// tick.
  std::uint64_t unreadable() const { return unreadable_; }
  /// Returns the interval of a thinned log, ticks; 1 if every tick has its output.
  int output_interval() const { return output_interval_; }
  /// The file: its size and its damage so far.
  const LogReader& log() const { return reader_; }

 private:
  /// True if the number is the next one: nothing was lost before it.
  bool Expected(const HapticSample& sample) const;
  bool Finish(const HapticSample& sample, bool has_output, LoggedTick* tick);
  void ReadInterval();

  LogReader reader_;
  std::function<void(const LogEvent&)> visit_;
  LogEvent event_;
  tool_t tool_{};
  force_t force_{};
  std::optional<HapticSample> waiting_;  // an input whose output may follow
  std::uint64_t next_tick_ = 0;          // after the last one returned
  std::uint64_t unreadable_ = 0;
  int output_interval_ = 1;
  TickIntervals intervals_{1};
};

/// One deformation step of a log.
struct LoggedStep {
  StepSample sample;
  std::int64_t visible_tick = kNeverVisible;
};

/// A session's log without its ticks, which TickReader reads. Constant.
class LoggedSession {
 public:
  /// Reads the whole file. Throws InputError if it cannot be read or holds no session.
  explicit LoggedSession(const std::string& path);

  const std::string& path() const { return path_; }
  /// Steps 1, 2, 3 and so on, up to the first that is missing.
  const std::vector<LoggedStep>& steps() const { return steps_; }
  /// Steps behind a missing one. A replay cannot use them.
  std::uint64_t steps_unusable() const { return steps_unusable_; }
  /// True if the session was closed: the log has its end.
  bool closed() const { return closed_; }
  std::uint64_t damaged_stretches() const { return damaged_stretches_; }
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }

  /// Returns why this log is not of a session of `info`: other instruments, organs, lattices or
  /// meshes, judged by the log's intact parts. Empty if it may be one. Coordinates may differ by a
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
