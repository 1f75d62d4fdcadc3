#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/types.h"

namespace lcm {
class LogFile;
}

namespace hpdm {

/// Why a log stopped growing.
enum class LogFailure {
  kNone,
  kWrite,     ///< A write failed (full disk, quota, I/O error): LogState::error says which.
  kVanished,  ///< The file was deleted while it was written.
};

struct LogState {
  LogFailure failure = LogFailure::kNone;
  int error = 0;              ///< errno of the failure.
  std::uint64_t events = 0;   ///< Accepted events; after a failure, the events that reached the
                              ///< file.
  std::uint64_t dropped = 0;  ///< Refused or lost because of the failure.
  std::uint64_t bytes = 0;    ///< Size of the accepted events in the file.
  bool moved = false;         ///< Its folder was moved or renamed; writing continues.

  /// One sentence with the remedy; empty without a failure.
  std::string Explain() const;
};

/// Writes an LCM event log with the caller's time stamps, so that a log of a virtual clock has the
/// same bytes in every run. Time stamps never run backwards in the file: an event older than the
/// one before it gets that one's time stamp (its message holds its own time).
///
/// After the first failure the log stays closed and every event is counted as dropped. The file
/// then holds whole events up to the last flush that succeeded. One thread.
class SessionLog {
 public:
  /// Creates or empties the file. `epoch_us` is added to every time stamp: wall time of the
  /// session's start in microseconds since 1970, or 0. Throws InputError if it cannot be opened.
  SessionLog(const std::string& path, std::int64_t epoch_us);
  ~SessionLog();
  SessionLog(const SessionLog&) = delete;
  SessionLog& operator=(const SessionLog&) = delete;

  /// Appends one event. Never throws; blocks as long as the file system does.
  void Write(const char* channel, Nanoseconds time, std::span<const std::uint8_t> data) noexcept;
  /// Appends one event with its time stamp unchanged, even if it runs backwards: for copies of
  /// logs.
  void Append(const char* channel, std::int64_t time_us,
              std::span<const std::uint8_t> data) noexcept;
  /// Hands everything to the operating system and checks that the file is still there. If it
  /// was moved within its file system, writing continues in its new place (LogState::moved).
  void Flush() noexcept;
  /// Flushes and closes. Events written later are counted as dropped.
  void Close() noexcept;

  const LogState& state() const { return state_; }

 private:
  void Fail(LogFailure failure, int error) noexcept;

  std::vector<char> stream_buffer_;  // before file_, whose stream uses it until it is closed
  std::string path_;
  std::unique_ptr<lcm::LogFile> file_;
  std::int64_t epoch_us_;
  std::int64_t last_us_;
  std::uint64_t flushed_events_ = 0;
  std::uint64_t flushed_bytes_ = 0;
  LogState state_;
};

/// One event of a log.
struct LogEvent {
  std::int64_t number = 0;
  std::int64_t time_us = 0;
  std::string channel;
  std::vector<std::uint8_t> data;
};

/// Reads LCM event logs, sound or damaged, without trusting a byte of them: lengths are checked
/// against what is left of the file before anything is reserved. An event counts as intact when a
/// further event or the end of the file follows it, and no zero is in its channel's name. One
/// thread.
class LogReader {
 public:
  /// Throws InputError if the file cannot be read or is compressed. The file's size
  /// is taken now: bytes that are appended later are not read.
  explicit LogReader(const std::string& path);

  /// Reads the next intact event and skips damage. False at the end. Reuses the event's memory.
  bool Next(LogEvent* event);

  /// Start of the event that Next gave last, bytes from the file's start.
  std::uint64_t event_start() const { return event_start_; }
  /// Place from which the next event is searched, bytes from the file's start.
  std::uint64_t position() const { return position_; }
  /// Continues from such a place. The counts of damage are kept.
  void Seek(std::uint64_t position) { position_ = position; }

  /// Skipped segments of bytes that held no intact event, so far, and their size. Damage that ends
  /// at the end of the file is a torn tail; it is counted here too.
  std::uint64_t damaged_stretches() const { return damaged_stretches_; }
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }
  /// End of the last intact event, bytes from the start: cutting here repairs a log that has
  /// only a torn tail.
  std::uint64_t intact_end() const { return intact_end_; }
  std::uint64_t size() const { return size_; }

 private:
  const std::uint8_t* View(std::uint64_t at, std::uint64_t bytes);
  bool IsBorder(std::uint64_t at) const;
  std::uint64_t ReadEventAt(std::uint64_t at, LogEvent* event);
  std::uint64_t FindSync(std::uint64_t from);

  class File {
   public:
    explicit File(const std::string& path);
    ~File();
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    int descriptor() const { return descriptor_; }

   private:
    int descriptor_;
  };
  File file_;
  std::uint64_t size_ = 0;
  std::vector<std::uint8_t> window_;  // bytes of the file from window_start_ on
  std::uint64_t window_start_ = 0;
  std::uint64_t event_start_ = 0;
  std::uint64_t position_ = 0;  // of the next event
  std::uint64_t intact_end_ = 0;
  std::uint64_t damaged_stretches_ = 0;
  std::uint64_t damaged_bytes_ = 0;
};

}  // namespace hpdm
