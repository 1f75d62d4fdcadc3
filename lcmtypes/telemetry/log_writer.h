#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/snapshots.h"
#include "lcmtypes/log/log.h"
#include "lcmtypes/telemetry/timeline.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

/// Writes a session's files: every message into session.lcmlog, and the thinned samples into
/// timeline.csv if one is asked for.
///
/// Thread: that of its owner. Guarantee: after the constructor nothing throws. A failed write (full
/// disk, quota, I/O error) ends that file with a whole event or row; the state says why and what is
/// missing, and the other file continues.
class LogWriter {
 public:
  struct Options {
    std::string log_path;
    std::int64_t epoch_us = 0;       ///< Added to the log's time stamps (SessionLog).
    std::string timeline_path = {};  ///< Empty: no time line.
    Nanoseconds timeline_interval = 0;
  };

  /// Creates the files. Throws InputError if one cannot be created.
  LogWriter(const Options& options, std::span<const std::string> instruments);

  /// Encodes a message, appends it and returns its bytes, also if the log has failed. They are
  /// valid until the next call.
  template <typename Message>
  std::span<const std::uint8_t> Write(const char* channel, Nanoseconds time,
                                      const Message& message) noexcept {
    const std::span<const std::uint8_t> bytes = EncodeMessage(message, &buffer_);
    log_.Write(channel, time, bytes);
    return bytes;
  }
  /// Adds a sample to the time line.
  void Add(const HapticSample& sample) noexcept;

  /// Hands everything to the operating system if the last time was 0.1 s of session time ago.
  void Flush(Nanoseconds now) noexcept;
  /// Flushes and closes both files.
  void Close() noexcept;

  const LogState& state() const { return log_.state(); }
  /// Returns why rows are missing in the time line; empty if none are.
  std::string TimelineFailure() const;

 private:
  SessionLog log_;
  std::optional<Timeline> timeline_;
  Nanoseconds last_flush_ = 0;
  std::vector<std::uint8_t> buffer_;  // reused, so that a steady session allocates nothing here
};

}  // namespace hpdm
