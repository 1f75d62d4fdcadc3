#include "lcmtypes/log_health.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <optional>
#include <utility>

#include "engine/error.h"
#include "lcmtypes/log.h"

namespace hpdm {
namespace {

class Channels {
 public:
  explicit Channels(const MessageSchemas& schemas) : schemas_(schemas) {}

  void Add(const LogEvent& event, LogHealth* health) {
    Channel& channel = channels_[event.channel];
    ChannelHealth& facts = channel.facts;
    if (facts.messages++ == 0) {
      channel.type = schemas_.Find(event.data);
      facts.channel = event.channel;
      facts.known = channel.type != nullptr;
      facts.type = schemas_.TypeOf(event.data);
      facts.first_us = event.time_us;
    }
    facts.bytes += event.data.size();
    facts.last_us = event.time_us;
    if (!facts.known) return;
    if (schemas_.Find(event.data) != channel.type || !Read(channel, event)) {
      ++facts.unreadable;
      return;
    }
    if (facts.type == "hpdm.event_t") Note(health);
    if (sequence_) Count(&channel);
  }

  std::vector<ChannelHealth> Facts() const {
    std::vector<ChannelHealth> facts;
    for (const auto& [name, channel] : channels_) facts.push_back(channel.facts);
    return facts;
  }

 private:
  struct Channel {
    ChannelHealth facts;
    const LcmStruct* type = nullptr;
    std::map<std::int64_t, std::int64_t> last;  // sequence number by instrument
  };

  bool Read(const Channel& channel, const LogEvent& event) {
    sequence_.reset();
    instrument_ = 0;
    name_.clear();
    return schemas_.Decode(*channel.type, event.data, [this](const MessageValue& value) {
      const auto* integer = std::get_if<std::int64_t>(&value.value);
      if (integer != nullptr && value.name == "sequence") sequence_ = *integer;
      if (integer != nullptr && value.name == "instrument") instrument_ = *integer;
      const auto* text = std::get_if<std::string_view>(&value.value);
      if (text != nullptr && value.name == "name") name_ = *text;
    });
  }

  void Note(LogHealth* health) const {
    health->session |= name_ == "session.start";
    health->closed |= name_ == "session.end";
  }

  void Count(Channel* channel) const {
    const auto [last, first] = channel->last.try_emplace(instrument_, *sequence_);
    if (first) return;
    if (*sequence_ <= last->second) {
      ++channel->facts.not_rising;
    } else {
      // Unsigned, since a damaged number may be as far from the last as there are numbers.
      const std::uint64_t missing =
          static_cast<std::uint64_t>(*sequence_) - static_cast<std::uint64_t>(last->second) - 1;
      channel->facts.gaps += missing > 0 ? 1 : 0;
      channel->facts.lost += missing;
    }
    last->second = std::max(last->second, *sequence_);
  }

  const MessageSchemas& schemas_;
  std::map<std::string, Channel> channels_;
  std::optional<std::int64_t> sequence_;  // of the message read last
  std::int64_t instrument_ = 0;
  std::string name_;
};

}  // namespace

bool LogHealth::Sound() const {
  if (damaged_bytes > 0 || torn_bytes > 0 || time_back > 0 || (session && !closed)) return false;
  return std::all_of(channels.begin(), channels.end(), [](const ChannelHealth& channel) {
    return channel.unreadable == 0 && channel.gaps == 0 && channel.not_rising == 0;
  });
}

LogHealth CheckLog(const std::string& path, const MessageSchemas& schemas) {
  LogReader reader(path);
  LogHealth health;
  Channels channels(schemas);
  std::int64_t last_us = 0;
  LogEvent event;
  while (reader.Next(&event)) {
    if (health.events++ > 0 && event.time_us < last_us) ++health.time_back;
    last_us = event.time_us;
    channels.Add(event, &health);
  }
  health.bytes = reader.size();
  health.torn_bytes = reader.size() - reader.intact_end();
  health.damaged_stretches = reader.damaged_stretches() - (health.torn_bytes > 0 ? 1 : 0);
  health.damaged_bytes = reader.damaged_bytes() - health.torn_bytes;
  health.channels = channels.Facts();
  return health;
}

std::uint64_t RepairLog(const std::string& from, const std::string& to) {
  LogReader reader(from);
  if (std::filesystem::exists(to)) {
    throw InputError(to + ": exists already; choose another name");
  }
  SessionLog log(to, 0);
  LogEvent event;
  while (reader.Next(&event)) log.Append(event.channel.c_str(), event.time_us, event.data);
  log.Close();
  if (log.state().failure != LogFailure::kNone) {
    throw InputError(to + ": " + log.state().Explain());
  }
  return log.state().events;
}

}  // namespace hpdm
