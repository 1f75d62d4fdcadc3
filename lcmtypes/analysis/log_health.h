#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/analysis/channel_facts.h"
#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// What `hpdm log check` finds in a log.
struct LogHealth {
  std::uint64_t bytes = 0;              ///< Size of the file.
  std::uint64_t events = 0;             ///< Intact ones.
  std::uint64_t damaged_stretches = 0;  ///< Bytes that are no intact event, but for the tail.
  std::uint64_t damaged_bytes = 0;
  std::uint64_t torn_bytes = 0;        ///< At the end, after the last intact event.
  std::uint64_t time_back = 0;         ///< Time stamps that run backwards.
  bool session = false;                ///< It holds one of ours,
  bool closed = false;                 ///< which ended in an orderly way.
  std::vector<ChannelFacts> channels;  ///< By name.

  /// Nothing is damaged, torn, lost, unreadable or out of order.
  bool Sound() const;
};

/// Reads a whole log. Throws InputError where the file cannot be read.
LogHealth CheckLog(const std::string& path, const MessageSchemas& schemas);

/// Writes the intact events of a log, with their time stamps, as a new log: damage in the middle is
/// left out, a torn tail cut. Returns how many. Throws InputError where either file cannot be used;
/// `to` must not exist.
std::uint64_t RepairLog(const std::string& from, const std::string& to);

}  // namespace hpdm
