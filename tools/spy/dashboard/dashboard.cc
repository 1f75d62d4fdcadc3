#include "tools/spy/dashboard/dashboard.h"

#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "tools/spy/dashboard/request_origin.h"

namespace hpdm {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// Longest time until a page's request is handled.
constexpr milliseconds kAnswerTime{10};

// Passes on the events and meshes before the player's position.
void Recall(LogPlayer* player, DashboardServer* server) {
  for (const char* channel : {kEventChannel, kMeshChannel}) {
    player->ForEachBefore(channel, [server](const LogEvent& event) { server->Recall(event); });
  }
}

void Seek(double position, LogPlayer* player, DashboardServer* server) {
  const double length = static_cast<double>(player->length_us()) / 1e6;
  player->Seek(position < length ? static_cast<std::int64_t>(position * 1e6) : player->length_us());
  server->Interrupt();
  Recall(player, server);
}

void Apply(const PlayerCommand& command, LogPlayer* player, DashboardServer* server) {
  switch (command.kind) {
    case PlayerCommand::kPlay:
      player->Pause(false);
      break;
    case PlayerCommand::kPause:
      player->Pause(true);
      break;
    case PlayerCommand::kSpeed:
      player->SetSpeed(command.value);
      break;
    case PlayerCommand::kSeek:
      Seek(command.value, player, server);
      break;
  }
}

PlayerStatus StatusOf(const LogPlayer& player) {
  return {player.paused(), player.ended(), player.speed(),
          static_cast<double>(player.position_us()) / 1e6,
          static_cast<double>(player.length_us()) / 1e6};
}

void Announce(const DashboardServer& server, const DashboardOptions& options,
              const std::string& source) {
  std::printf("%s: %s (Ctrl-C ends it)\n", source.c_str(), server.address().c_str());
  if (options.host != "127.0.0.1" && options.host != "localhost" && options.host != "::1") {
    const std::vector<std::string> names = NamesOfMachine();
    std::string where = options.host;
    if (IsAllAddresses(options.host)) {
      where = names.empty() ? "this machine"
                            : "http://" + names[0] + ":" + std::to_string(server.port()) + "/";
    }
    std::printf(
        "note: everybody who can reach %s sees the session; without --host only this machine can\n",
        where.c_str());
  }
  std::fflush(stdout);
}

}  // namespace

void ServeDashboard(const DashboardOptions& options, const MessageSchemas& schemas,
                    const StopSignals& stop, SpySource* source) {
  LogPlayer* player = source->player();
  DashboardServer server(options, source->name(), player != nullptr, schemas);
  if (player != nullptr) Recall(player, &server);  // events before --from
  Announce(server, options, source->name());

  LogEvent event;
  bool ended = false;
  auto look_at = steady_clock::now();
  for (;;) {
    if (source->messages().Next(&event, kAnswerTime)) {
      if (player != nullptr) event.time_us = player->event_us();
      server.Take(event);
    }
    if (steady_clock::now() < look_at) continue;
    look_at = steady_clock::now() + kAnswerTime;
    if (stop.WaitFor(0)) return;
    server.SetDropped(source->dropped());
    if (player == nullptr) continue;
    for (const PlayerCommand& command : server.TakeCommands()) Apply(command, player, &server);
    if (player->ended() && !ended) server.Finish();
    ended = player->ended();
    server.Set(StatusOf(*player));
    // At the log's end reading does not wait, so this thread waits here.
    if (ended && stop.WaitFor(std::chrono::nanoseconds(kAnswerTime).count())) return;
  }
}

}  // namespace hpdm
