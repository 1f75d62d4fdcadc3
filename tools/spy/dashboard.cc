#include "tools/spy/dashboard.h"

#include <cstdio>
#include <filesystem>
#include <memory>

#include "lcmtypes/live_source.h"
#include "lcmtypes/log_player.h"
#include "lcmtypes/network.h"
#include "tools/stop_signals.h"

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
  std::printf("%s: %s (end: Ctrl-C)\n", source.c_str(), server.address().c_str());
  if (options.host != "127.0.0.1" && options.host != "localhost" && options.host != "::1") {
    std::printf(
        "note: whoever reaches %s sees the session; without --host only this machine does\n",
        options.host.c_str());
  }
  std::fflush(stdout);
}

}  // namespace

void RunDashboard(const std::string& log, const DashboardOptions& options) {
  const StopSignals signals;  // before any thread
  std::unique_ptr<LiveSource> live;
  std::unique_ptr<LogPlayer> player;
  if (log.empty()) {
    live = std::make_unique<LiveSource>(NetworkUrl(), "spy --web");
  } else {
    player = std::make_unique<LogPlayer>(log);
  }
  const std::string source = log.empty() ? "live on " + NetworkUrl() : log;
  DashboardServer server(options, source, player != nullptr);
  Announce(server, options, source);

  MessageSource& messages = player ? static_cast<MessageSource&>(*player) : *live;
  LogEvent event;
  bool ended = false;
  auto look_at = steady_clock::now();
  for (;;) {
    if (messages.Next(&event, kPatience)) server.Take(event);
    if (steady_clock::now() < look_at) continue;
    look_at = steady_clock::now() + kPatience;
    if (signals.WaitFor(0)) return;
    if (live) {
      server.SetDropped(live->dropped());
      continue;
    }
    for (const PlayerCommand& command : server.TakeCommands()) {
      Obey(command, player.get(), &server);
    }
    if (player->ended() && !ended) server.Finish();
    ended = player->ended();
    server.Set(StatusOf(*player));
    // Nothing is read then, which would not wait.
    if (ended && signals.WaitFor(std::chrono::nanoseconds(kPatience).count())) return;
  }
}

}  // namespace hpdm
