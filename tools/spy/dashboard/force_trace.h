#pragma once

#include <array>
#include <cstdint>
#include <deque>

#include "engine/snapshots.h"
#include "hpdm/force_t.hpp"

namespace hpdm {

/// Force and depth of each hand over the last minute, as the peaks of every 1/30 s. One thread.
class ForceTrace {
 public:
  static constexpr Nanoseconds kInterval = kNanosecondsPerSecond / 30;
  static constexpr std::size_t kMaxRows = 1800;

  struct Row {
    std::int64_t interval = 0;  ///< Number of the interval: its time / kInterval.
    int tool_count = 0;
    std::array<float, kMaxInstruments> force{};                ///< N, largest |force on the hand|.
    std::array<float, kMaxInstruments> depth{};                ///< m, largest depth of the tip.
    std::array<std::uint32_t, kMaxInstruments> guard_flags{};  ///< All flags that were set.
  };

  /// Peaks of one instrument since the trace began.
  struct Peak {
    double force = 0;  ///< N.
    double depth = 0;  ///< m.
  };

  /// Adds a tick. A tick older than the newest interval counts only for the peaks. Values that are
  /// not finite count as 0. The message has at most kMaxInstruments tools.
  void Add(const force_t& force);
  /// Ends the present interval.
  void Finish();
  void Clear() { *this = ForceTrace(); }

  /// Returns the finished rows in memory; first_row() is the number of the first, from 0.
  const std::deque<Row>& rows() const { return rows_; }
  std::uint64_t first_row() const { return dropped_; }
  const std::array<Peak, kMaxInstruments>& peaks() const { return peaks_; }
  /// Returns the session time of the first tick, ns; -1 before it.
  Nanoseconds begin_ns() const { return begin_ns_; }

 private:
  std::deque<Row> rows_;
  std::uint64_t dropped_ = 0;
  Row filling_;
  bool filling_any_ = false;
  std::array<Peak, kMaxInstruments> peaks_{};
  Nanoseconds begin_ns_ = -1;
};

}  // namespace hpdm
