#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "lcmtypes/log/message_source.h"
#include "lcmtypes/wire/codec.h"

namespace hpdm {

/// Computes at what time since the log's start each event is played, from time stamps that may be
/// wrong.
///
/// 1. A single time stamp that is out of order with both its neighbours (a flipped bit) is put
///    between them.
/// 2. Where the clock was set back, or forward by more than kMaxSilenceUs, there is no pause. The
///    same holds after a first and before a last time stamp that is as far from its only neighbour.
class PlayTime {
 public:
  /// One hour. A longer jump is taken for a change of the clock and is skipped.
  static constexpr std::int64_t kMaxSilenceUs = 3'600'000'000;

  /// Returns the play time of an event stamped `time_us` that comes before one stamped `next_us`
  /// (null for the last event), in microseconds. It never falls.
  std::int64_t Advance(std::int64_t time_us, const std::int64_t* next_us);

 private:
  bool started_ = false;
  std::int64_t last_us_ = 0;  // time stamp, mended
  std::int64_t played_us_ = 0;
};

/// Clock of a player: the machine's, or a test's.
struct PlayClock {
  std::function<Nanoseconds()> now;
  std::function<void(Nanoseconds)> sleep;  ///< Sleeps for a duration.
};

/// Plays a log in time. The constructor reads it once for its length, damage and an index (about 1
/// s for 1 GB that the system holds in memory). Damage is skipped.
///
/// No event is left out: a slow reader slows the play. One thread.
class LogPlayer : public MessageSource {
 public:
  static constexpr double kSlowest = 0.1;
  static constexpr double kFastest = 100;
  static constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  /// Messages from this long before a seek's target are played immediately. So viewers have the
  /// newest message of every channel that sends once a second, even while paused.
  static constexpr std::int64_t kLeadInUs = 1'500'000;
  static constexpr std::size_t kMaxIndexed = 100'000;

  /// `indexed`: channels whose messages ForEachBefore can give (each one's first kMaxIndexed).
  /// Plays from the start at speed 1. Throws InputError if the file cannot be read.
  explicit LogPlayer(const std::string& path,
                     const std::vector<std::string>& indexed = {kMeshChannel, kEventChannel},
                     PlayClock clock = {});

  bool Next(LogEvent* event, std::chrono::milliseconds patience) override;
  bool ended() const override { return !has_next_; }

  /// Sets the speed relative to real time: kSlowest to kFastest (clamped), or kUnlimited.
  void SetSpeed(double speed);
  double speed() const { return speed_; }
  void Pause(bool paused);
  bool paused() const { return paused_; }

  /// Continues from `position_us` (clamped), after the `lead_in_us` before it. The next events do
  /// not follow the last ones: counters must be interrupted (ChannelTable::Interrupt).
  void Seek(std::int64_t position_us, std::int64_t lead_in_us = kLeadInUs);

  /// Microseconds since the log's start.
  std::int64_t position_us() const;
  std::int64_t length_us() const { return length_us_; }

  /// Play time of the event that Next gave last. Rates are counted by it, since time stamps may be
  /// damaged.
  std::int64_t event_us() const { return event_us_; }

  /// Calls `visit` with every message of an indexed channel that was sent before the next event, in
  /// order. Meshes, for example, are at the log's start only. The play is not moved.
  void ForEachBefore(const std::string& channel, const std::function<void(const LogEvent&)>& visit);
  /// Calls `visit` with the newest such message of every indexed channel that has one.
  void ForNewestBefore(const std::function<void(const LogEvent&)>& visit);

  std::uint64_t events() const { return events_; }  ///< Intact events of the whole log.
  std::uint64_t damaged_stretches() const { return damaged_stretches_; }
  std::uint64_t damaged_bytes() const { return damaged_bytes_; }
  std::uint64_t size() const { return reader_.size(); }  ///< Size of the file, bytes.

 private:
  struct Mark {
    std::uint64_t offset;  // of the first event that is not in `time`
    std::int64_t played_us;
    PlayTime time;
  };

  void BuildIndex(const std::vector<std::string>& indexed);
  void GoTo(const Mark& mark);
  bool Read(LogEvent* event, std::uint64_t* offset);
  void Advance();
  double DueIn() const;
  std::span<const std::uint64_t> Before(const std::vector<std::uint64_t>& offsets) const;
  void Visit(std::span<const std::uint64_t> offsets,
             const std::function<void(const LogEvent&)>& visit);
  void StartClockAt(std::int64_t position_us);

  LogReader reader_;
  PlayClock clock_;

  std::vector<Mark> marks_;                                    // one every kMarkBytes of the file
  std::map<std::string, std::vector<std::uint64_t>> indexed_;  // offsets
  std::int64_t length_us_ = 0;
  std::uint64_t events_ = 0, damaged_stretches_ = 0, damaged_bytes_ = 0;

  // The next event to hand out, and the one after it, whose time stamp the next one's time needs.
  LogEvent next_, after_;
  bool has_next_ = false, has_after_ = false;
  std::uint64_t next_offset_ = 0, after_offset_ = 0;
  std::int64_t next_us_ = 0;  // play time of next_
  std::int64_t event_us_ = 0;
  PlayTime time_;

  double speed_ = 1;
  bool paused_ = false;
  // Position `clock_position_us_` was at `clock_start_`.
  std::int64_t clock_position_us_ = 0;
  Nanoseconds clock_start_ = 0;
};

}  // namespace hpdm
