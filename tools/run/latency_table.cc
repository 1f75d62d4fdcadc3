#include "tools/run/latency_table.h"

namespace hpdm {

std::string LatencyTable(const Latencies& latencies) {
  std::string text = "latency,upper_ns,count\n";
  latencies.ForEach([&](std::size_t index, const Histogram& histogram) {
    histogram.ForEachBin([&](std::int64_t upper_ns, std::uint64_t count) {
      text.append(kLatencyNames[index]).append(",").append(std::to_string(upper_ns));
      text.append(",").append(std::to_string(count)).append("\n");
    });
  });
  return text;
}

}  // namespace hpdm
