#include "tools/spy/once_report.h"

#include <chrono>
#include <cstdio>

#include "lcmtypes/live/wall_time.h"
#include "tools/shared/report_text.h"
#include "tools/spy/terminal/spy_text.h"

namespace hpdm {
namespace {

using Json = nlohmann::ordered_json;

Json ToJson(const ChannelTable::Last& last, const MessageSchemas& schemas) {
  Json values = Json::object(), units = Json::object();
  schemas.Decode(*last.type, last.event->data, [&values, &units](const MessageValue& value) {
    // All names of a message differ, so they are appended without a look-up.
    auto& items = values.get_ref<Json::object_t&>();
    std::visit(
        [&](const auto& v) {
          items.push_back({std::string(value.name), Json(v)});
        },
        value.value);
    if (!value.unit.empty()) {
      units.get_ref<Json::object_t&>().push_back(
          {std::string(value.name), std::string(value.unit)});
    }
  });
  return {
      {"time_us", last.event->time_us}, {"values", std::move(values)}, {"units", std::move(units)}};
}

Json ToJson(const ChannelRow& row) {
  const ChannelFacts& facts = row.facts;
  return {{"channel", facts.channel},
          {"type", facts.type},
          {"known", facts.known},
          {"messages", facts.messages},
          {"bytes", facts.bytes},
          {"first_us", facts.first_us},
          {"last_us", facts.last_us},
          {"mean_rate_hz", facts.Rate()},
          {"rate_hz", row.flow.rate_hz},
          {"bytes_per_s", row.flow.bytes_per_s},
          {"jitter_s", row.flow.jitter_s},
          {"mean_interval_s", row.flow.mean_interval_s},
          {"p99_interval_s", row.flow.p99_interval_s},
          {"longest_interval_s", row.flow.longest_interval_s},
          {"unreadable", facts.unreadable},
          {"gaps", facts.gaps},
          {"lost", facts.lost},
          {"not_rising", facts.not_rising}};
}

}  // namespace

void Watch(SpySource* source, double seconds, const StopSignals& stop, SpyReport* report) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kPatience = std::chrono::milliseconds(50);
  const LogPlayer* player = source->player();
  const std::int64_t from_us = player != nullptr ? player->position_us() : 0;
  const Clock::time_point start = Clock::now();
  const auto elapsed = [&] {
    return player != nullptr ? 1e-6 * static_cast<double>(player->position_us() - from_us)
                             : std::chrono::duration<double>(Clock::now() - start).count();
  };
  LogEvent event;
  MessageSource& messages = source->messages();
  for (std::uint64_t turn = 0; elapsed() < seconds && !messages.ended(); ++turn) {
    if (turn % 1024 == 0 && stop.WaitFor(0)) break;
    if (messages.Next(&event, kPatience)) {
      report->table.Add(event);
      report->now_us = event.time_us;
    } else if (stop.WaitFor(0)) {
      break;
    }
  }
  report->source = source->name();
  report->log = player != nullptr;
  report->seconds = elapsed();
  report->dropped = source->dropped();
  if (player != nullptr) {
    report->damaged_bytes = player->damaged_bytes();
  } else {
    report->now_us = WallTimeUs();
  }
}

Json ToJson(const SpyReport& report, const MessageSchemas& schemas) {
  Json json = {{"source", report.source},
               {"log", report.log},
               {"seconds", report.seconds},
               {"messages", report.table.messages()},
               {"dropped", report.dropped},
               {"damaged_bytes", report.damaged_bytes},
               {"other_messages", report.table.other_messages()},
               {"other_bytes", report.table.other_bytes()},
               {"channels", Json::array()}};
  for (const ChannelRow& row : report.table.Rows(report.now_us)) {
    Json channel = ToJson(row);
    const ChannelTable::Last last = report.table.Find(row.facts.channel);
    if (last.type != nullptr && last.event != nullptr) {
      channel["last"] = ToJson(last, schemas);
    }
    json["channels"].push_back(std::move(channel));
  }
  return json;
}

void Print(const SpyReport& report) {
  std::printf("%-20s %-18s %11s %9s %9s %9s %11s %7s %10s\n", "channel", "type", "messages",
              "rate Hz", "jitter", "longest", "bandwidth", "lost", "unreadable");
  for (const ChannelRow& row : report.table.Rows(report.now_us)) {
    const ChannelFacts& facts = row.facts;
    std::printf("%-20s %-18s %11s %9s %9s %9s %11s %7s %10s\n", Printable(facts.channel).c_str(),
                Printable(facts.type).c_str(), WithCommas(facts.messages).c_str(),
                RateText(row).c_str(), JitterText(row.flow.jitter_s, row).c_str(),
                JitterText(row.flow.longest_interval_s, row).c_str(),
                BandwidthText(row.flow.bytes_per_s).c_str(), WithCommas(facts.lost).c_str(),
                WithCommas(facts.unreadable).c_str());
  }
  std::printf(
      "%s messages in %.3g s; rate, jitter (standard deviation of the interval), longest "
      "interval and bandwidth over the last %.0f s, at most %s messages\n",
      WithCommas(report.table.messages()).c_str(), report.seconds,
      1e-6 * static_cast<double>(ChannelTable::kChannelWindowUs),
      WithCommas(ChannelTable::kMaxChannelArrivals).c_str());
  const auto print = [](const char* what, std::uint64_t count) {
    if (count > 0) std::printf("%s: %s\n", what, WithCommas(count).c_str());
  };
  print("messages of further channels that do not fit the table", report.table.other_messages());
  print("messages lost because they came too fast", report.dropped);
  print("damaged bytes of the log", report.damaged_bytes);
}

}  // namespace hpdm
