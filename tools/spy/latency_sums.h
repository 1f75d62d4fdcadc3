#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>

#include "engine/latency.h"
#include "hpdm/stats_t.hpp"

namespace hpdm {

/// The latencies of a session, summed over its HPDM_STATS messages. Memory is bounded: bins beyond
/// those that a Histogram has are ignored. One thread.
class LatencySums {
 public:
  void Add(const stats_t& stats);

  /// For each distribution, in the order of Latency: name, count, p50, p99, p999 and max (ns), and
  /// `bins`: pairs of a rising power and a count, where values of the power k lie in
  /// (2^((k - 1) / 4), 2^(k / 4)] ns: four bins an octave.
  nlohmann::json ToJson() const;

 private:
  struct Sum {
    std::map<std::int64_t, std::uint64_t> bins;  // by the largest value in the bin
    std::uint64_t count = 0;
    std::int64_t max_ns = 0;
    std::int64_t Percentile(double fraction) const;
  };
  std::array<Sum, kLatencyCount> sums_;
};

}  // namespace hpdm
