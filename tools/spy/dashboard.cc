#include "tools/spy/dashboard.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>

namespace hpdm {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// How long a page waits for an answer to what it asked.
constexpr milliseconds kPatience{10};

void Obey(const PlayerCommand& command, LogPlayer* player, DashboardServer* server) {
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
      player->Seek(static_cast<std::int64_t>(
          std::min(command.value, static_cast<double>(player->length_us()) / 1e6) * 1e6));
      server->Interrupt();
      player->ForEachBefore(kEventChannel,
                            [server](const LogEvent& event) { server->Recall(event); });
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
    std::printf(
        "note: whoever reaches %s sees the session; without --host only this machine does\n",
        options.host.c_str());
  }
  std::fflush(stdout);
}

}  // namespace

void ServeDashboard(const DashboardOptions& options, const MessageSchemas& schemas,
                    const StopSignals& stop, SpySource* source) {
  LogPlayer* player = source->player();
  DashboardServer server(options, source->name(), player != nullptr, schemas);
  Announce(server, options, source->name());

  LogEvent event;
  bool ended = false;
  auto look_at = steady_clock::now();
  for (;;) {
    if (source->messages().Next(&event, kPatience)) server.Take(event);
    if (steady_clock::now() < look_at) continue;
    look_at = steady_clock::now() + kPatience;
    if (stop.WaitFor(0)) return;
    server.SetDropped(source->dropped());
    if (player == nullptr) continue;
    for (const PlayerCommand& command : server.TakeCommands()) Obey(command, player, &server);
    if (player->ended() && !ended) server.Finish();
    ended = player->ended();
    server.Set(StatusOf(*player));
    // Nothing is read then, which would not wait.
    if (ended && stop.WaitFor(std::chrono::nanoseconds(kPatience).count())) return;
  }
}

}  // namespace hpdm
