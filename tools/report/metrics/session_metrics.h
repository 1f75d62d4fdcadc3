#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/snapshots.h"
#include "engine/threads/latency.h"
#include "engine/threads/loop_event.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tools/report/metrics/motion_metrics.h"
#include "tools/report/metrics/uniform_time_series.h"

namespace hpdm {

/// N: one standard deviation above the largest force of experts in a suturing task on artificial
/// tissue (2.6 N, 0.4 N), where that of novices was 4.7 N (Horeman et al. 2010). What tissues bear
/// differs tenfold (Rodrigues et al. 2012): the trainer sets the limit for the task.
inline constexpr double kDefaultForceLimit = 3;
/// Contacts apart by less than this are one, s: the tip did not leave the organ.
inline constexpr double kContactPause = 0.05;

/// Forces of one instrument, of all contacts or of those with one organ. Times are of ticks with a
/// contact, the periods skipped after a tick included.
struct ContactMetrics {
  double time = 0;                     ///< s.
  std::uint64_t count = 0;             ///< Contacts.
  double peak_force = 0;               ///< N, largest |force on the hand|.
  double forces_off = 0;               ///< s of `time`, while the device was to show no forces.
  double clamped = 0;                  ///< s of `time`, with more force than the device can show.
  double mean_force = 0;               ///< N, over `time` without `forces_off`.
  double impulse = 0;                  ///< N s, integral of |force| over `time`.
  double over_limit = 0;               ///< s, with |force| above the limit.
  std::uint64_t over_limit_count = 0;  ///< Times that it rose above it.
  double deepest_press = 0;            ///< m, of the tip below the released surface.
};

/// One of the instruments that a hand held.
struct UsedInstrument {
  int instrument_index = 0;  ///< 0: the hand's first, then its exchanges in the scene's order.
  std::uint64_t nth = 0;     ///< Of all exchanges of the session, the one that brought it; 0: none.
  std::string name;
};

/// The figures are a hand's, whatever it held.
struct HandReport {
  std::string name;                  ///< Of its first instrument.
  std::vector<UsedInstrument> held;  ///< In the order of their first use; at least one.
  MotionMetrics motion;
  ContactMetrics contact;                ///< With any organ.
  std::vector<ContactMetrics> by_organ;  ///< By index of organ.
  double device_lost = 0;                ///< s, without a usable pose.

  /// For people: the instruments that it held.
  std::string Label() const;
};

/// Durations of one kind over the session.
struct LatencyReport {
  std::string_view name;  ///< Of kLatencyNames.
  std::uint64_t count = 0;
  Nanoseconds p50 = 0, p90 = 0, p99 = 0, p99_9 = 0, max = 0;
  std::vector<std::pair<Nanoseconds, std::uint64_t>> bins;  ///< Largest value in the bin, count.
};

struct SessionEvent {
  double time = 0;  ///< s.
  EventSeverity severity = EventSeverity::kInfo;
  std::string name, text;
};

/// What the log holds of itself.
struct LogReport {
  std::uint64_t bytes = 0, events = 0;
  std::uint64_t damaged_bytes = 0;  ///< That are no intact event, but for the tail.
  std::uint64_t torn_bytes = 0;     ///< At the end, after the last intact event.
  std::uint64_t unreadable = 0;     ///< Messages of a session's channels that hold nothing usable.
  std::uint64_t lost = 0;           ///< Messages of those channels missing by sequence number.
  std::uint64_t ticks_lost = 0;     ///< Ticks that ran but are not in the log.
  std::uint64_t outputs_lost = 0;   ///< Ticks whose HPDM_FORCE is missing.
  bool closed = false;              ///< The session ended in an orderly way.

  bool Sound() const {
    return closed &&
           damaged_bytes + torn_bytes + unreadable + lost + ticks_lost + outputs_lost == 0;
  }
  /// One line each of what is wrong, for people; empty when sound.
  std::vector<std::string> Faults() const;
};

/// A session in figures. Definitions and sources: tools/report/README.md.
struct SessionReport {
  std::string log;            ///< Path.
  std::string scene;          ///< Name; empty: not known.
  std::int64_t start_us = 0;  ///< Wall time of its start since 1970; 0: the lockstep clock.
  bool measured = false;      ///< On the real clock: latencies mean something.
  double duration = 0;        ///< s, from the first tick to the last one's end.
  double active = 0;          ///< s, of it neither paused nor missing in the log.
  double paused = 0;          ///< s.
  double force_limit = kDefaultForceLimit;  ///< N.
  std::vector<std::string> organs;          ///< Names by index.
  std::vector<HandReport> hands;
  std::optional<double> both_moving;  ///< s, with two hands.
  std::uint64_t ticks = 0;
  std::uint64_t exchanges = 0;  ///< Times that a hand took another instrument.
  SkippedTicks skipped;
  std::array<LatencyReport, kLatencyCount> latencies;
  double stolen = 0;            ///< s, that the host took from the machine's processors.
  std::int64_t steps_shed = 0;  ///< Deformation steps that did less for want of time.
  LogReport health;
  std::vector<SessionEvent> events;
};

/// What the page draws beside the figures.
struct SessionTimeSeries {
  struct Peaks {  ///< Of the ticks of one kMotionPeriod.
    float force = 0, depth = 0;
    std::int8_t organ = -1;  ///< In contact with; -1: none.
  };
  struct Hand {
    std::vector<TimeSeriesSegment> segments;
    std::vector<Peaks> peaks;  ///< From `start` on, every kMotionPeriod.
  };
  double start = 0;  ///< s, session time of the first tick.
  std::vector<Hand> hands;
  std::vector<std::pair<double, double>> pauses;  ///< s, session time.
  std::vector<OrganDescription> organs;           ///< At rest; those whose mesh is whole.
  std::vector<std::string> organs_missing;        ///< Why others are not, for people.
};

struct SessionReading {
  SessionReport report;
  SessionTimeSeries series;
};

/// Reads a session's log once, sound or damaged: what is intact counts. `force_limit` in N. Throws
/// InputError where the file cannot be read or contains no haptic tick.
SessionReading ReadSession(const std::string& log, double force_limit = kDefaultForceLimit);

}  // namespace hpdm
