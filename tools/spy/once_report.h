#pragma once

#include <nlohmann/json.hpp>

#include "lcmtypes/analysis/channel_table.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// What `hpdm spy --once` saw.
struct SpyReport {
  std::string source;  ///< The network's URL, or the log's path.
  bool log = false;
  double seconds = 0;         ///< Watched; of a log, its time from the first to the last event.
  std::uint64_t dropped = 0;  ///< Came from the network and were not read in time.
  std::uint64_t damaged_bytes = 0;  ///< Of the log.
  ChannelTable table;
  std::int64_t now_us = 0;  ///< Time stamp of the end.

  explicit SpyReport(const MessageSchemas& schemas) : table(schemas) {}
};

/// Reads `seconds` of the source (a log's own seconds from its position on, as fast as it is read
/// unless its speed was set by the caller; what a seek plays of the time before would be counted
/// too), or less when a stop is asked for or a log ends.
void Watch(SpySource* source, double seconds, const StopSignals& stop, SpyReport* report);

/// Everything about every channel, and its last message's values by name. Numbers that JSON does
/// not have (NaN, infinities) are null.
nlohmann::ordered_json ToJson(const SpyReport& report, const MessageSchemas& schemas);

/// The same as a table for people, without the values.
void Print(const SpyReport& report);

}  // namespace hpdm
