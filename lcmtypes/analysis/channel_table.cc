#include "lcmtypes/analysis/channel_table.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "lcmtypes/wire/codec.h"

namespace hpdm {
namespace {

constexpr double kPortion = 0.1;  // s

// Returns seconds as a double: differences of foreign time stamps may not fit into 64 bits.
double Seconds(std::int64_t from_us, std::int64_t to_us) {
  return 1e-6 * (static_cast<double>(to_us) - static_cast<double>(from_us));
}

}  // namespace

bool ChannelTable::Add(const LogEvent& event) {
  ++messages_;
  auto found = channels_.find(event.channel);
  if (found == channels_.end()) {
    const bool of_session = std::find(std::begin(kSessionChannels), std::end(kSessionChannels),
                                      event.channel) != std::end(kSessionChannels);
    if (channels_.size() >= kMaxChannels && !of_session) {
      ++other_messages_;
      other_bytes_ += event.data.size();
      return false;
    }
    found = channels_.emplace(event.channel, schemas_).first;
  }
  Channel& channel = found->second;
  const Arrival arrival = {event.time_us, static_cast<std::uint32_t>(event.data.size())};
  if (channel.arrivals.size() < kMaxChannelArrivals) {
    channel.arrivals.push_back(arrival);
  } else {
    channel.arrivals[channel.next] = arrival;
    channel.next = (channel.next + 1) % kMaxChannelArrivals;
  }
  const bool was_known = channel.counter.facts().known;
  const bool readable = channel.counter.Add(event);
  if (channel.counter.facts().known != was_known) channel.has_last = false;  // had another type
  if (readable != channel.counter.facts().known || event.data.size() > kMaxKeptBytes) {
    return readable;
  }
  channel.has_last = true;
  channel.last = event;
  return readable;
}

void ChannelTable::Interrupt() {
  for (auto& [name, channel] : channels_) {
    channel.counter.Interrupt();
    channel.arrivals.clear();
    channel.next = 0;
    channel.has_last = false;
  }
}

void ChannelTable::Recall(const LogEvent& event) {
  const auto found = channels_.find(event.channel);
  if (found == channels_.end() || event.data.size() > kMaxKeptBytes) return;
  Channel& channel = found->second;
  const LcmStruct* type = channel.counter.type();
  MessageOrder order;
  if (schemas_.Find(event.data) != type) return;
  if (type != nullptr && !schemas_.Check(*type, event.data, &order)) return;
  channel.has_last = true;
  channel.last = event;
}

std::vector<ChannelRow> ChannelTable::Rows(std::int64_t now_us) const {
  std::vector<ChannelRow> rows;
  rows.reserve(channels_.size());
  std::vector<double> intervals;
  for (const auto& [name, channel] : channels_) {
    rows.push_back({channel.counter.facts(), channel.Flow(now_us, &intervals)});
  }
  return rows;
}

ChannelTable::Last ChannelTable::Find(std::string_view channel) const {
  const auto found = channels_.find(channel);
  if (found == channels_.end()) return {};
  return {found->second.counter.type(), found->second.has_last ? &found->second.last : nullptr};
}

ChannelFlow ChannelTable::Channel::Flow(std::int64_t now_us, std::vector<double>* intervals) const {
  intervals->clear();
  const auto at = [this](std::size_t i) -> const Arrival& {
    return arrivals[(next + i) % arrivals.size()];
  };
  const double window = 1e-6 * static_cast<double>(kChannelWindowUs);
  std::size_t first = 0;
  while (first < arrivals.size() && Seconds(at(first).time_us, now_us) > window) ++first;
  const std::size_t count = arrivals.size() - first;
  if (count < 2) return {};

  double bytes = at(first).bytes, sum = 0;
  for (std::size_t i = first + 1; i < arrivals.size(); ++i) {
    // Time stamps of a foreign log may run backwards.
    intervals->push_back(std::max(0.0, Seconds(at(i - 1).time_us, at(i).time_us)));
    sum += intervals->back();
    bytes += at(i).bytes;
  }
  const auto n = static_cast<double>(intervals->size());
  ChannelFlow flow;
  flow.mean_interval_s = sum / n;
  const double expected = sum > 0 ? n / sum : 0;
  const double since_first = Seconds(at(first).time_us, now_us) - kPortion;
  flow.rate_hz = since_first > 0 ? std::min(expected, (n + 1) / since_first) : expected;
  flow.bytes_per_s = flow.rate_hz * bytes / (n + 1);
  double squares = 0;
  for (const double interval : *intervals) {
    squares += (interval - flow.mean_interval_s) * (interval - flow.mean_interval_s);
  }
  // Stamps are in microseconds: a deviation below a thousandth of one is rounding.
  const double deviation = std::sqrt(squares / n);
  flow.jitter_s = deviation < 1e-9 ? 0 : deviation;
  const auto rank = static_cast<std::ptrdiff_t>(std::ceil(0.99 * n)) - 1;
  std::nth_element(intervals->begin(), intervals->begin() + rank, intervals->end());
  flow.p99_interval_s = (*intervals)[static_cast<std::size_t>(rank)];
  flow.longest_interval_s = *std::max_element(intervals->begin() + rank, intervals->end());
  return flow;
}

}  // namespace hpdm
