#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "lcmtypes/analysis/channel_facts.h"

namespace hpdm {

/// Rates and intervals of a channel over the last kChannelWindowUs, or over the last
/// kMaxChannelArrivals messages if that is shorter, by time stamps. An interval is from one message
/// of the channel to the next.
struct ChannelFlow {
  /// Hz: (n - 1) / (last - first) over the window's n messages. At most n / (now - 0.1 s - first),
  /// so that it falls when the channel is silent. Senders and readers work in batches, so a tenth
  /// of a second without messages is not silence. 0 for fewer than two messages.
  double rate_hz = 0;
  double bytes_per_s = 0;         ///< The rate times the mean size of the window's messages.
  double jitter_s = 0;            ///< Standard deviation of the intervals.
  double mean_interval_s = 0;     ///< Mean of the intervals.
  double p99_interval_s = 0;      ///< Value that 99 % of the intervals do not exceed (nearest
                                  ///< rank).
  double longest_interval_s = 0;  ///< Longest interval.
};

struct ChannelRow {
  ChannelFacts facts;
  ChannelFlow flow;
};

/// Channels of a network or a log for a viewer: counts, flow and the last message of each. Memory
/// is bounded by kMaxChannels channels, kMaxChannelArrivals arrivals and kMaxKeptBytes of each last
/// message. A session's own channels have room beside the kMaxChannels, so a flood of names cannot
/// hide a session. One thread; the schemas outlive the table.
class ChannelTable {
 public:
  static constexpr std::size_t kMaxChannels = 256;
  static constexpr std::int64_t kChannelWindowUs = 5'000'000;
  static constexpr std::size_t kMaxChannelArrivals = 4096;
  static constexpr std::size_t kMaxKeptBytes = 1 << 20;

  explicit ChannelTable(const MessageSchemas& schemas) : schemas_(schemas) {}

  /// Counts a message. True if it has the channel's type and exactly its size.
  bool Add(const LogEvent& event);

  /// Marks a jump, as a seek in a log: no loss and no interval is counted over it. The last
  /// messages are removed, since they may be later than the new place.
  void Interrupt();
  /// Sets a channel's last message before the new place, after an interruption. Does not count it.
  void Recall(const LogEvent& event);

  /// Returns the channels by name, with their flow at time `now_us`: the wall clock for a network,
  /// the position for a log. Costs a partial sort of the window per channel, so call it a few times
  /// a second.
  std::vector<ChannelRow> Rows(std::int64_t now_us) const;

  struct Last {
    const LcmStruct* type = nullptr;  ///< Null: not known.
    const LogEvent* event = nullptr;  ///< The newest message that is readable and not too long;
                                      ///< null without one. Of a type not known: the newest.
  };
  Last Find(std::string_view channel) const;

  /// Number of all messages, including the channels for which the table has no room.
  std::uint64_t messages() const { return messages_; }
  /// Messages of channels without room in the table, and their bytes.
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
