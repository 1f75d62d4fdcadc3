#include "lcmtypes/analysis/log_health.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <string_view>

#include "engine/base/error.h"
#include "lcmtypes/log/log.h"

namespace hpdm {
namespace {

void NoteEvent(const MessageSchemas& schemas, const LcmStruct& type, const LogEvent& event,
               LogHealth* health) {
  schemas.Decode(type, event.data, [health](const MessageValue& value) {
    const auto* text = std::get_if<std::string_view>(&value.value);
    if (text == nullptr || value.name != "name") return;
    health->session |= *text == "session.start";
    health->closed |= *text == "session.end";
  });
}

}  // namespace

bool LogHealth::Sound() const {
  if (events == 0) return false;  // the file is not a log
  if (damaged_bytes > 0 || torn_bytes > 0 || time_back > 0 || (session && !closed)) return false;
  return std::all_of(channels.begin(), channels.end(), [](const ChannelFacts& channel) {
    return channel.unreadable == 0 && channel.gaps == 0 && channel.not_rising == 0;
  });
}

LogHealth CheckLog(const std::string& path, const MessageSchemas& schemas) {
  LogReader reader(path);
  LogHealth health;
  std::map<std::string, ChannelCounter> channels;
  std::int64_t last_us = 0;
  LogEvent event;
  while (reader.Next(&event)) {
    if (health.events++ > 0 && event.time_us < last_us) ++health.time_back;
    last_us = event.time_us;
    ChannelCounter& channel = channels.try_emplace(event.channel, schemas).first->second;
    if (channel.Add(event) && channel.type()->name == "hpdm.event_t") {
      NoteEvent(schemas, *channel.type(), event, &health);
    }
  }
  health.bytes = reader.size();
  health.torn_bytes = reader.size() - reader.intact_end();
  health.damaged_stretches = reader.damaged_stretches() - (health.torn_bytes > 0 ? 1 : 0);
  health.damaged_bytes = reader.damaged_bytes() - health.torn_bytes;
  for (const auto& [name, channel] : channels) health.channels.push_back(channel.facts());
  return health;
}

std::uint64_t RepairLog(const std::string& from, const std::string& to) {
  LogReader reader(from);
  std::error_code ignored;
  if (std::filesystem::exists(to, ignored)) {
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
