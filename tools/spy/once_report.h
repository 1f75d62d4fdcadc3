#pragma once

#include <nlohmann/json.hpp>

#include "lcmtypes/analysis/channel_table.h"
#include "tools/session/stop_signals.h"
#include "tools/spy/spy_source.h"

namespace hpdm {

/// Result of `hpdm spy --once`.
struct SpyReport {
  std::string source;  ///< The network's URL, or the log's path.
  bool log = false;
  double seconds = 0;               ///< Time watched; for a log, from its first to its last event.
  std::uint64_t dropped = 0;        ///< Messages from the network that were not read in time.
  std::uint64_t damaged_bytes = 0;  ///< Damaged bytes of the log.
  ChannelTable table;
  std::int64_t now_us = 0;  ///< Time stamp of the end.

  explicit SpyReport(const MessageSchemas& schemas) : table(schemas) {}
};

/// Reads `seconds` of the source, less if a signal comes or a log ends. For a log these are its own
/// seconds from its position on, and the speed is the caller's. Events that a seek replays are
/// counted too.
void Watch(SpySource* source, double seconds, const StopSignals& stop, SpyReport* report);

/// Returns the facts of every channel and the values of its last message by name. NaN and
/// infinities, which JSON lacks, are null.
nlohmann::ordered_json ToJson(const SpyReport& report, const MessageSchemas& schemas);

/// Prints the same as a table for people, without the values.
void Print(const SpyReport& report);

}  // namespace hpdm
