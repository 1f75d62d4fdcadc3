#pragma once

#include <string>

#include "engine/threads/latency.h"

namespace hpdm {

/// latency.csv: the distributions of a session, one row `latency,upper_ns,count` a bin that holds
/// values (`upper_ns` its largest), rising within each latency. Tables of several sessions may be
/// put together: counts of equal bins add up.
std::string LatencyTable(const Latencies& latencies);

}  // namespace hpdm
