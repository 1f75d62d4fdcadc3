#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/threads/latency.h"
#include "hpdm/stats_t.hpp"

namespace hpdm {

/// The latencies of a session, summed over its HPDM_STATS messages. Bins that a Histogram cannot
/// have are ignored, so memory is bounded. One thread.
class LatencySums {
 public:
  struct Sum {
    std::map<std::int64_t, std::uint64_t> bins;  ///< Counts by the largest value in the bin, ns.
    std::uint64_t count = 0;
    std::int64_t max_ns = 0;
    /// Returns the percentile as Histogram::Percentile does, ns. Without values it returns the
    /// largest.
    std::int64_t Percentile(double fraction) const;
  };

  void Add(const stats_t& stats);

  /// Returns the sum of one distribution; `latency` is a Latency.
  const Sum& Of(std::size_t latency) const { return sums_[latency]; }

  /// Returns for each distribution, in the order of Latency: name, count, p50, p99 and max (ns),
  /// and `bins`. A bin is a pair of a power k and a count: the values lie in (2^((k - 1) / 4), 2^(k
  /// / 4)] ns, four bins an octave, in rising order.
  nlohmann::json ToJson() const;

 private:
  std::array<Sum, kLatencyCount> sums_;
};

}  // namespace hpdm
