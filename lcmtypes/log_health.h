#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "lcmtypes/message_schema.h"

namespace hpdm {

/// What a log holds of one channel.
struct ChannelHealth {
  std::string channel;
  std::string type;    ///< "hpdm.tool_t"; the hash in hexadecimal where it is not known.
  bool known = false;  ///< The type is.
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;    ///< Of the messages alone.
  std::int64_t first_us = 0;  ///< Time stamps.
  std::int64_t last_us = 0;
  std::uint64_t unreadable = 0;  ///< Not one message of the channel's type.
  std::uint64_t gaps = 0;        ///< Places where the sequence numbers jump,
  std::uint64_t lost = 0;        ///< and the messages missing there.
  std::uint64_t not_rising = 0;  ///< Sequence numbers that repeat or go back.

  /// Messages a second, from the first to the last.
  double Rate() const {
    return last_us > first_us
               ? 1e6 * static_cast<double>(messages - 1) / static_cast<double>(last_us - first_us)
               : 0;
  }
};

/// What `hpdm log check` finds in a log.
struct LogHealth {
  std::uint64_t bytes = 0;              ///< Size of the file.
  std::uint64_t events = 0;             ///< Intact ones.
  std::uint64_t damaged_stretches = 0;  ///< Bytes that are no intact event, but for the tail.
  std::uint64_t damaged_bytes = 0;
  std::uint64_t torn_bytes = 0;         ///< At the end, after the last intact event.
  std::uint64_t time_back = 0;          ///< Time stamps that run backwards.
  bool session = false;                 ///< It holds one of ours,
  bool closed = false;                  ///< which ended in an orderly way.
  std::vector<ChannelHealth> channels;  ///< By name.

  /// Nothing is damaged, torn, lost, unreadable or out of order.
  bool Sound() const;
};

/// Reads a whole log. Sequence numbers are those of a member `sequence`, counted for each value of
/// a member `instrument` where a type has one. Throws InputError where the file cannot be read.
LogHealth CheckLog(const std::string& path, const MessageSchemas& schemas);

/// Writes the intact events of a log, with their time stamps, as a new log: damage in the middle is
/// left out, a torn tail cut. Returns how many. Throws InputError where either file cannot be used;
/// `to` must not exist.
std::uint64_t RepairLog(const std::string& from, const std::string& to);

}  // namespace hpdm
