#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/handling_limits.h"
#include "engine/exercise/exercise_evaluator.h"
#include "engine/snapshots.h"
#include "engine/threads/latency.h"
#include "engine/threads/loop_event.h"
#include "lcmtypes/wire/mesh_codec.h"
#include "tools/report/metrics/motion_metrics.h"
#include "tools/report/metrics/uniform_time_series.h"

namespace hpdm {

/// Contacts separated by less than this count as one, s.
inline constexpr double kContactPause = 0.05;

/// Forces of one instrument, in all contacts or in those with one organ. Times are sums over ticks
/// with a contact, including the periods skipped after a tick.
struct ContactMetrics {
  double time = 0;                     ///< s in contact.
  std::uint64_t count = 0;             ///< Number of contacts.
  double peak_force = 0;               ///< N, largest |TissueForce()|.
  double forces_off = 0;               ///< s of `time` with forces switched off.
  double clamped = 0;                  ///< s of `time` with more force than the device can display.
  double mean_force = 0;               ///< N, over `time` without `forces_off`.
  double impulse = 0;                  ///< N s, integral of |force| over `time`.
  double over_limit = 0;               ///< s with |force| above the limit.
  std::uint64_t over_limit_count = 0;  ///< Number of times that |force| rose above the limit.
  double deepest_press = 0;            ///< m, depth of the tip below the released surface.
  double over_depth = 0;               ///< s with the tip deeper than the depth limit.
  std::uint64_t over_depth_count = 0;  ///< Number of times that it went deeper than the limit.
  std::uint64_t slips = 0;  ///< Number of times that tissue slipped in the jaws (SlipCounter).
};

/// An instrument that a hand held.
struct UsedInstrument {
  int instrument_index = 0;  ///< 0: the hand's first, then its exchanges in the scene's order.
  std::string name;
};

/// Figures of a hand, over all instruments that it held.
struct HandReport {
  std::string name;                  ///< Name of its first instrument.
  std::vector<UsedInstrument> held;  ///< In the order of their first use; at least one.
  MotionMetrics motion;
  ContactMetrics contact;                ///< With any organ.
  std::vector<ContactMetrics> by_organ;  ///< By index of organ.
  double device_lost = 0;                ///< s without a usable pose.
  double depth_unknown = 0;  ///< s of contact whose depth is no press of the tip (DepthFilter).

  /// Returns the names of the instruments that it held, for people.
  std::string Label() const;
  /// Returns the name of one of them; the hand's own name if it did not hold that.
  const std::string& InstrumentName(int instrument_index) const;
};

/// Durations of one kind over the session.
struct LatencyReport {
  std::string_view name;  ///< One of kLatencyNames.
  std::uint64_t count = 0;
  Nanoseconds p50 = 0, p90 = 0, p99 = 0, p99_9 = 0, max = 0;
  std::vector<std::pair<Nanoseconds, std::uint64_t>> bins;  ///< Largest value in the bin, count.
};

/// The layer of one attachment over the session.
struct AttachmentReport {
  std::string name;           ///< "gallbladder and liver"; "attachment 1" without a scene.
  double peak_load = 0;       ///< N, largest force of the layer on an organ.
  double largest_damage = 0;  ///< 0..1, at the end.
  double freed_area = 0;      ///< m^2, at the end.
  double burnt_area = 0;      ///< m^2 of it.
  double cut_area = 0;        ///< m^2 of it. The rest is torn.
  double dissipated = 0;      ///< J, at the end.
};

/// The scene's exercise, judged by the log.
struct ExerciseReport {
  ExerciseOptions options;
  ExerciseResult result;
};

struct SessionEvent {
  double time = 0;  ///< s since the first tick; negative while the session was prepared.
  EventSeverity severity = EventSeverity::kInfo;
  std::string name, text;
};

/// Health of a log.
struct LogReport {
  std::uint64_t bytes = 0, events = 0;
  std::uint64_t damaged_bytes = 0;  ///< Bytes between intact events.
  std::uint64_t torn_bytes = 0;     ///< Bytes after the last intact event.
  std::uint64_t unreadable = 0;     ///< Unusable messages on a session's channels.
  std::uint64_t lost = 0;           ///< Messages of those channels missing by sequence number.
  std::uint64_t ticks_lost = 0;     ///< Ticks that ran but are not in the log.
  std::uint64_t outputs_lost = 0;  ///< Ticks whose HPDM_FORCE is missing (LoggedTick::output_lost).
  bool closed = false;             ///< True if the session ended normally.

  bool Sound() const {
    return closed &&
           damaged_bytes + torn_bytes + unreadable + lost + ticks_lost + outputs_lost == 0;
  }
  /// Returns one line per fault, for people; empty if the log is sound.
  std::vector<std::string> Faults() const;
};

/// A session in figures. Definitions and sources: tools/report/README.md. Its times count from the first
/// tick, as the exercise's do: its first step has the time of that tick.
struct SessionReport {
  std::string log;            ///< Path.
  std::string scene;          ///< Name; empty if unknown.
  bool left_handed = false;   ///< The first two instruments had exchanged their ports.
  std::int64_t start_us = 0;  ///< Wall time of the first tick since 1970; 0: the lockstep clock.
  bool measured = false;      ///< True on the real clock, where latencies are measured.
  double duration = 0;        ///< s, from the first tick to the end of the last.
  double active = 0;          ///< s of `duration` that are neither paused nor missing in the log.
  double paused = 0;          ///< s.
  double force_limit = kDefaultForceLimit;  ///< N.
  double depth_limit = kDefaultDepthLimit;  ///< m.
  std::vector<std::string> organs;          ///< Names by index.
  std::vector<HandReport> hands;
  std::vector<AttachmentReport> attachments;  ///< In the scene's order.
  std::optional<ExerciseReport> exercise;     ///< Of a scene with one.
  std::optional<double> both_moving;          ///< s in which both tips move; only with two hands.
  std::optional<WorkTimes> work;              ///< Only with two hands or more.
  std::uint64_t ticks = 0;
  int output_interval = 1;      ///< Ticks that share an output in a thinned log (--log-rate).
  std::uint64_t exchanges = 0;  ///< Number of times that a hand took another instrument.
  SkippedTicks skipped;
  std::array<LatencyReport, kLatencyCount> latencies;
  double stolen = 0;            ///< CPU steal, s: time that the host took from the processors.
  std::int64_t steps_shed = 0;  ///< Deformation steps with reduced quality for lack of time.
  LogReport health;
  std::vector<SessionEvent> events;
};

/// Data of the page's drawings.
struct SessionTimeSeries {
  struct Peaks {  ///< Peaks over the ticks of one kMotionPeriod.
    float force = 0, depth = 0;
    std::int8_t organ = -1;  ///< Organ in contact; -1: none.
    bool holds = false;      ///< The jaws hold tissue.
  };
  struct Hand {
    std::vector<TimeSeriesSegment> segments;
    std::vector<Peaks> peaks;  ///< Every kMotionPeriod from `start` on.
  };
  double start = 0;  ///< s, time of the first tick: 0 in a reading.
  std::vector<Hand> hands;
  std::vector<std::pair<double, double>> pauses;  ///< s since the first tick.
  std::vector<OrganDescription> organs;           ///< Organs at rest with a complete mesh.
  std::vector<std::string> organs_missing;        ///< Why others are missing, for people.
};

struct SessionReading {
  SessionReport report;
  SessionTimeSeries series;
};

/// Reads a session's log once. The intact part of a damaged log counts. `force_limit` in N,
/// `depth_limit` in m. `instruments` (SceneInstruments) names the instruments that the ticks hold.
/// If they are another session's, or none, exchanges are named by number: "exchange 1". `exercise` is
/// judged by the log. Throws
/// InputError if the file cannot be read or contains no haptic tick.
SessionReading ReadSession(const std::string& log, double force_limit = kDefaultForceLimit,
                           const std::vector<std::vector<std::string>>& instruments = {},
                           double depth_limit = kDefaultDepthLimit,
                           const std::optional<ExerciseOptions>& exercise = {});

}  // namespace hpdm
