#pragma once

#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "engine/base/handling_limits.h"
#include "engine/snapshots.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/analysis/slip_counter.h"
#include "tools/report/metrics/depth_filter.h"
#include "tools/report/metrics/session_metrics.h"
#include "tools/report/metrics/uniform_time_series.h"

namespace hpdm {

/// Sums over the ticks of one instrument: over all contacts, or over those with one organ.
class ContactSums {
 public:
  explicit ContactSums(const HandlingLimits& limits) : limits_(limits) {}

  /// Adds a tick that holds for `duration`, s. `counts`: its force and depth belong to these
  /// contacts. `touches`: the tick is in contact.
  void Add(double time, double duration, const ToolSample& tool, bool counts, bool touches);
  /// Skips a pause or lost ticks, s: the time does not count and separates no contacts.
  void SkipTime(double duration) { end_ += duration; }
  ContactMetrics Metrics() const;

 private:
  HandlingLimits limits_;
  ContactMetrics metrics_;
  double contact_impulse_ = 0;                             // N s, while the device shows forces
  double end_ = -std::numeric_limits<double>::infinity();  // of the last contact
  bool over_force_ = false, over_depth_ = false;
  SlipCounter slips_;
};

/// Computes the hands' part of a session's report from a log's ticks. A tick holds until the next
/// one. One thread.
class SessionTicks {
 public:
  /// `most_peaks` limits the peaks of a time series, so wrong times in a damaged log cannot use
  /// unlimited memory. Later ticks are not drawn.
  SessionTicks(const HandlingLimits& limits, std::size_t most_peaks)
      : limits_(limits), most_peaks_(most_peaks) {}

  /// Adds a tick. Returns false if it cannot follow the last one or its values are impossible.
  bool Add(const LoggedTick& logged);
  /// Fills in the hands, the times, the ticks and the time series. Call once, at the end.
  void Fill(SessionReading* reading);

 private:
  struct Hand {
    explicit Hand(const HandlingLimits& limits) : all(limits) {}
    void SkipTime(double duration) {
      all.SkipTime(duration);
      for (ContactSums& organ : organs) organ.SkipTime(duration);
    }
    UniformTimeSeries series;
    ContactSums all;
    std::vector<ContactSums> organs;
    std::vector<SessionTimeSeries::Peaks> peaks;
    DepthFilter depth;
    double device_lost = 0, depth_unknown = 0;
    int instrument_index = 0;
    std::vector<UsedInstrument> held = {{}};
  };

  static double Time(const HapticSample& sample) { return ToSeconds(sample.time_ns); }

  void Begin(const HapticSample& sample);
  bool Follows(const HapticSample& sample) const;
  void NoteExchanges(const HapticSample& sample);
  void KnowPeriod(const HapticSample& sample, std::uint64_t lost);
  /// Replaces a tick's missing output by the previous one.
  void HoldOutput(HapticSample* sample) const;
  /// Adds the last tick, which holds until `until`, s.
  void Close(double until);
  void AddPeaks(const ToolSample& tool, double time, double until,
                std::vector<SessionTimeSeries::Peaks>* peaks) const;

  HandlingLimits limits_;
  std::size_t most_peaks_;
  bool begun_ = false;
  std::uint64_t ticks_ = 0;
  std::uint64_t exchanges_ = 0;
  double start_ = 0, period_ = 0.001, paused_ = 0, missing_ = 0;
  bool measured_ = false;
  SkippedTicks skipped_;
  HapticSample last_;
  std::vector<Hand> hands_;
  std::vector<std::pair<double, double>> pauses_;
};

}  // namespace hpdm
