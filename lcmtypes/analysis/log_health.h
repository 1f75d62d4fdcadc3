#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/analysis/channel_facts.h"
#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Results of `hpdm log check`.
struct LogHealth {
  std::uint64_t bytes = 0;              ///< Size of the file.
  std::uint64_t events = 0;             ///< Intact events.
  std::uint64_t damaged_stretches = 0;  ///< Segments without an intact event, except for the tail.
  std::uint64_t damaged_bytes = 0;
  std::uint64_t torn_bytes = 0;        ///< After the last intact event.
  std::uint64_t time_back = 0;         ///< Time stamps that run backwards.
  bool session = false;                ///< It holds a session of this project.
  bool closed = false;                 ///< That session was closed.
  std::vector<ChannelFacts> channels;  ///< Sorted by name.

  /// True if nothing is damaged, torn, lost, unreadable or out of order.
  bool Sound() const;
};

/// Reads a whole log. Throws InputError if the file cannot be read.
LogHealth CheckLog(const std::string& path, const MessageSchemas& schemas);

/// Writes the intact events of a log, with their time stamps, as a new log without damage and
/// without a torn tail. Returns their number. Throws InputError if either file cannot be used; `to`
/// must not exist.
std::uint64_t RepairLog(const std::string& from, const std::string& to);

}  // namespace hpdm
