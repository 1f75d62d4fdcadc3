#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/threads/latency.h"
#include "hpdm/stats_t.hpp"

namespace hpdm {

/// The latencies of a session, summed over its HPDM_STATS messages. Memory is bounded: bins beyond
/// those that a Histogram has are ignored. One thread.
class LatencySums {
 public:
  struct Sum {
    std::map<std::int64_t, std::uint64_t> bins;  ///< By the largest value in the bin, ns.
    std::uint64_t count = 0;
    std::int64_t max_ns = 0;
    /// As Histogram::Percentile, ns; the largest without values.
    std::int64_t Percentile(double fraction) const;
  };

  void Add(const stats_t& stats);

  /// Of one distribution, by Latency.
  const Sum& Of(std::size_t latency) const { return sums_[latency]; }

  /// For each distribution, in the order of Latency: name, count, p50, p99 and max (ns), and
  /// `bins`: pairs of a rising power and a count, where values of the power k lie in
  /// (2^((k - 1) / 4), 2^(k / 4)] ns: four bins an octave.
  nlohmann::json ToJson() const;

 private:
  std::array<Sum, kLatencyCount> sums_;
};

}  // namespace hpdm
