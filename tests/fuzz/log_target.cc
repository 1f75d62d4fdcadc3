#include <filesystem>
#include <vector>

#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/analysis/logged_session.h"
#include "lcmtypes/log/log.h"
#include "tests/fuzz/input_file.h"

namespace hpdm::fuzz {
namespace {

struct Contents {
  std::vector<LogEvent> events;
  std::uint64_t intact_bytes = 0;
};

/// Every byte is an intact event's or damage, and Seek goes back to each event.
Contents ReadAll(const std::string& path) {
  constexpr std::uint64_t kHeaderBytes = 28;
  LogReader reader(path);
  Contents contents;
  LogEvent event;
  std::uint64_t end = 0;
  std::vector<std::uint64_t> starts;
  while (reader.Next(&event)) {
    HPDM_ENSURE(reader.event_start() >= end);
    end = reader.position();
    HPDM_ENSURE(reader.event_start() + kHeaderBytes + event.channel.size() + event.data.size() ==
                end);
    HPDM_ENSURE(!event.channel.empty());
    HPDM_ENSURE(event.channel.find('\0') == std::string::npos);
    starts.push_back(reader.event_start());
    contents.intact_bytes += end - reader.event_start();
    contents.events.push_back(event);
  }
  HPDM_ENSURE(reader.intact_end() == end);
  HPDM_ENSURE(contents.intact_bytes + reader.damaged_bytes() == reader.size());
  for (std::size_t i = starts.size(); i-- > 0;) {
    reader.Seek(starts[i]);
    HPDM_ENSURE(reader.Next(&event) && event.data == contents.events[i].data);
  }
  return contents;
}

void EnsureSameFacts(const ChannelFacts& a, const ChannelFacts& b) {
  HPDM_ENSURE(a.channel == b.channel && a.type == b.type && a.known == b.known);
  HPDM_ENSURE(a.messages == b.messages && a.bytes == b.bytes && a.unreadable == b.unreadable);
  HPDM_ENSURE(a.first_us == b.first_us && a.last_us == b.last_us);
  HPDM_ENSURE(a.gaps == b.gaps && a.lost == b.lost && a.not_rising == b.not_rising);
}

/// A repaired log is whole and holds what was intact, no more and no less.
void EnsureRepairs(const std::string& path, const std::string& to, const Contents& contents) {
  std::filesystem::remove(to);
  HPDM_ENSURE(RepairLog(path, to) == contents.events.size());
  const LogHealth before = CheckLog(path, MessageSchemas::Hpdm());
  const LogHealth after = CheckLog(to, MessageSchemas::Hpdm());
  HPDM_ENSURE(before.bytes == contents.intact_bytes + before.damaged_bytes + before.torn_bytes);
  HPDM_ENSURE(after.damaged_stretches == 0 && after.damaged_bytes == 0 && after.torn_bytes == 0);
  HPDM_ENSURE(after.bytes == contents.intact_bytes);
  HPDM_ENSURE(after.events == before.events && after.time_back == before.time_back);
  HPDM_ENSURE(after.session == before.session && after.closed == before.closed);
  HPDM_ENSURE(after.channels.size() == before.channels.size());
  for (std::size_t c = 0; c < after.channels.size(); ++c) {
    EnsureSameFacts(before.channels[c], after.channels[c]);
  }
  const Contents again = ReadAll(to);
  for (std::size_t e = 0; e < again.events.size(); ++e) {
    const LogEvent &a = contents.events[e], &b = again.events[e];
    HPDM_ENSURE(a.channel == b.channel && a.data == b.data && a.time_us == b.time_us);
  }
}

void EnsureTicksRise(const std::string& path) {
  TickReader reader(path);
  LoggedTick tick;
  std::uint64_t next = 0;
  while (reader.Next(&tick)) {
    HPDM_ENSURE(tick.sample.tick >= next);
    HPDM_ENSURE(tick.lost_before <= tick.sample.tick - next);
    next = tick.sample.tick + 1;
    HPDM_ENSURE(tick.sample.tool_count >= 0 && tick.sample.tool_count <= kMaxInstruments);
  }
}

void EnsureStepsRise(const std::string& path) {
  const LoggedSession session(path);
  std::uint64_t number = 0;
  for (const LoggedStep& step : session.steps()) {
    HPDM_ENSURE(step.sample.step.number == ++number);
    HPDM_ENSURE(step.sample.tool_count <= kMaxInstruments);
    HPDM_ENSURE(step.sample.organ_count <= kMaxOrgans);
  }
  SessionInfo info;
  info.organs.resize(1);
  session.WhyAnother(info);
}

}  // namespace

bool LogFile(Bytes bytes) {
  static const InputFile file("session.lcmlog");
  static const std::string repaired = file / "repaired.lcmlog";
  file.Write(bytes);
  try {
    const LogReader opened(file.path());
  } catch (const InputError& error) {  // It begins as a compressed log.
    EnsureOneLine(error, file.path());
    return false;
  }
  EnsureRepairs(file.path(), repaired, ReadAll(file.path()));
  EnsureTicksRise(file.path());
  try {
    EnsureStepsRise(file.path());
    return true;
  } catch (const InputError& error) {
    EnsureOneLine(error, file.path());
    return false;
  }
}

}  // namespace hpdm::fuzz
