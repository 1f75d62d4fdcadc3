#include "tools/shared/latency_sums.h"

#include <algorithm>
#include <cmath>

namespace hpdm {
namespace {

// A Histogram has 32 bins, and 32 in each of the 58 powers of two above them.
constexpr std::size_t kMaxBins = 59 * 32;

}  // namespace

void LatencySums::Add(const stats_t& stats) {
  for (std::size_t i = 0; i < kLatencyCount; ++i) {
    sums_[i].max_ns = std::max(sums_[i].max_ns, stats.latencies[i].max_ns);
  }
  for (const bin_t& bin : stats.bins) {
    if (bin.distribution < 0 || static_cast<std::size_t>(bin.distribution) >= kLatencyCount) {
      continue;
    }
    Sum& sum = sums_[static_cast<std::size_t>(bin.distribution)];
    if (bin.upper_ns < 0 || bin.count <= 0) continue;
    if (sum.bins.size() >= kMaxBins && !sum.bins.contains(bin.upper_ns)) continue;
    sum.bins[bin.upper_ns] += static_cast<std::uint64_t>(bin.count);
    sum.count += static_cast<std::uint64_t>(bin.count);
  }
}

std::int64_t LatencySums::Sum::Percentile(double fraction) const {
  const double wanted = fraction * static_cast<double>(count) * (1 - 1e-12);
  std::uint64_t seen = 0;
  for (const auto& [upper, values] : bins) {
    seen += values;
    if (static_cast<double>(seen) >= wanted) return std::min(upper, max_ns);
  }
  return max_ns;
}

nlohmann::json LatencySums::ToJson() const {
  nlohmann::json all = nlohmann::json::array();
  for (std::size_t i = 0; i < kLatencyCount; ++i) {
    const Sum& sum = sums_[i];
    if (sum.count == 0) continue;
    std::map<int, std::uint64_t> coarse;
    for (const auto& [upper, values] : sum.bins) {
      const double ns = static_cast<double>(std::max<std::int64_t>(upper, 1));
      coarse[static_cast<int>(std::ceil(4 * std::log2(ns)))] += values;
    }
    nlohmann::json bins = nlohmann::json::array();
    for (const auto& [power, values] : coarse) bins.push_back({power, values});
    all.push_back({{"name", kLatencyNames[i]},
                   {"count", sum.count},
                   {"p50", sum.Percentile(0.5)},
                   {"p99", sum.Percentile(0.99)},
                   {"max", sum.max_ns},
                   {"bins", bins}});
  }
  return all;
}

}  // namespace hpdm
