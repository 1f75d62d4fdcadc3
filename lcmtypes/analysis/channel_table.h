#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/analysis/channel_facts.h"

namespace hpdm {

/// How a channel's messages came over the last kChannelWindow (or kMaxChannelArrivals messages,
/// where those are fewer), by time stamps. An interval is from one message of the channel to the
/// next.
struct ChannelFlow {
  /// Hz: (n - 1) / (last - first) over the window's n messages, and at most n / (now - 0.1 s -
  /// first), so that it falls when the channel is silent (senders and readers work in portions: a
  /// tenth of a second without a message is none). 0 for fewer than two messages.
  double rate_hz = 0;
  double bytes_per_s = 0;         ///< The rate times the mean size of the window's messages.
  double jitter_s = 0;            ///< Standard deviation of the intervals,
  double mean_interval_s = 0;     ///< their mean,
  double p99_interval_s = 0;      ///< the one that 99 % of them do not exceed (nearest rank),
  double longest_interval_s = 0;  ///< and the longest.
};

struct ChannelRow {
  ChannelFacts facts;
  ChannelFlow flow;
};

/// The channels of a network or a log as a viewer shows them: counts, flow and the last message of
/// each. Memory is bounded whatever comes: by kMaxChannels channels (a session's own find room
/// beside them, so that no flood of names hides a session), kMaxChannelArrivals arrivals and
/// kMaxKeptBytes of each one's last message. One thread; the schemas outlive the table.
class ChannelTable {
 public:
  static constexpr std::size_t kMaxChannels = 256;
  static constexpr std::int64_t kChannelWindowUs = 5'000'000;
  static constexpr std::size_t kMaxChannelArrivals = 4096;
  static constexpr std::size_t kMaxKeptBytes = 1 << 20;

  explicit ChannelTable(const MessageSchemas& schemas) : schemas_(schemas) {}

  /// Counts a message. True when it is one of the channel's type, of exactly its size.
  bool Add(const LogEvent& event);

  /// The messages to come do not follow those before (a seek in a log): no loss and no interval is
  /// counted between them, and the last messages may be of a time to come: they are forgotten.
  void Interrupt();
  /// After an interruption: the last message of a channel before the place. It is not counted.
  void Recall(const LogEvent& event);

  /// By name, with each one's flow at time `now_us`: the wall clock for a network, the position for
  /// a log. Costs a partial sort of the window per channel: for a few times a second.
  std::vector<ChannelRow> Rows(std::int64_t now_us) const;

  struct Last {
    const LcmStruct* type = nullptr;  ///< Null: not known.
    const LogEvent* event = nullptr;  ///< The newest message that is readable and not too long;
                                      ///< null without one. Of a type not known: the newest.
  };
  Last Find(std::string_view channel) const;

  /// All messages, those of the channels that found no room in the table included.
  std::uint64_t messages() const { return messages_; }
  /// Messages of those, and their bytes.
  std::uint64_t other_messages() const { return other_messages_; }
  std::uint64_t other_bytes() const { return other_bytes_; }

 private:
  struct Arrival {
    std::int64_t time_us;
    std::uint32_t bytes;
  };
  struct Channel {
    explicit Channel(const MessageSchemas& schemas) : counter(schemas) {}
    ChannelFlow Flow(std::int64_t now_us, std::vector<double>* intervals) const;

    ChannelCounter counter;
    std::vector<Arrival> arrivals;  // a ring once it is full
    std::size_t next = 0;           // place in the ring
    bool has_last = false;
    LogEvent last;
  };

  const MessageSchemas& schemas_;
  std::map<std::string, Channel, std::less<>> channels_;
  std::uint64_t messages_ = 0;
  std::uint64_t other_messages_ = 0, other_bytes_ = 0;
};

}  // namespace hpdm
