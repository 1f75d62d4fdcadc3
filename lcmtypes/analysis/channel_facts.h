#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/message_schema.h"

namespace hpdm {

/// Counts of one channel.
struct ChannelFacts {
  std::string channel;
  std::string type;    ///< "hpdm.tool_t"; the hash in hexadecimal if the type is unknown.
  bool known = false;  ///< The type is known.
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;    ///< Size of the messages alone.
  std::int64_t first_us = 0;  ///< Time stamps.
  std::int64_t last_us = 0;
  std::uint64_t unreadable = 0;  ///< Messages that are not exactly one message of the channel's
                                 ///< type.
  std::uint64_t gaps = 0;        ///< Places where the sequence numbers jump.
  std::uint64_t lost = 0;        ///< Messages missing there.
  std::uint64_t not_rising = 0;  ///< Sequence numbers that repeat or fall.

  /// Returns the messages a second, from the first to the last.
  double Rate() const {
    if (last_us <= first_us) return 0;
    // The difference of foreign time stamps may not fit into 64 bits.
    const double us = static_cast<double>(last_us) - static_cast<double>(first_us);
    return 1e6 * static_cast<double>(messages - 1) / us;
  }
};

/// Counts the messages of one channel. One thread; the schemas outlive it.
///
/// 1. The first message of a known type sets the channel's type. A message is readable if it has a
///    hash of that type and exactly its size.
/// 2. Sequence numbers are the member `sequence`, counted for each value of a member `instrument`
///    if the type has one (at most kMaxInstrumentsCounted values).
/// 3. A restarted sender, which counts from the beginning again, is followed after kRestartRun
///    messages.
class ChannelCounter {
 public:
  static constexpr int kRestartRun = 10;
  static constexpr std::size_t kMaxInstrumentsCounted = 1024;

  explicit ChannelCounter(const MessageSchemas& schemas) : schemas_(&schemas) {}

  /// Counts a message. True if it is readable.
  bool Add(const LogEvent& event);

  /// Counts no loss between the last message and the next one.
  void Interrupt() { sequences_.clear(); }

  const ChannelFacts& facts() const { return facts_; }
  const LcmStruct* type() const { return type_; }  ///< Null while it is unknown.

 private:
  struct Sequence {
    std::int64_t highest;
    std::int64_t previous;  // of the message before
    int run = 0;            // messages that follow one another below the highest
  };
  void Count(const MessageOrder& order);

  const MessageSchemas* schemas_;
  ChannelFacts facts_;
  const LcmStruct* type_ = nullptr;
  std::map<std::int64_t, Sequence> sequences_;  // by instrument
};

}  // namespace hpdm
