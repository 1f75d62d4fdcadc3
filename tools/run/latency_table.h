#pragma once

#include <string>

#include "engine/threads/latency.h"

namespace hpdm {

/// Returns the text of latency.csv: one row `latency,upper_ns,count` per bin that holds values.
/// `upper_ns` is the bin's largest value and rises within each latency. Tables of several sessions
/// can be merged by adding the counts of equal bins.
std::string LatencyTable(const Latencies& latencies);

}  // namespace hpdm
