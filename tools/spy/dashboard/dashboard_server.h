#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "lcmtypes/log/log.h"
#include "tools/spy/dashboard/dashboard_state.h"

namespace httplib {
class DataSink;
struct Request;
struct Response;
}  // namespace httplib

namespace hpdm {

class RequestServer;

struct DashboardOptions {
  std::string host = "127.0.0.1";
  int port = 8090;  ///< 0: any free one.
};

/// Where a log's player stands.
struct PlayerStatus {
  bool paused = false;
  bool ended = false;
  double speed = 1;
  double position = 0;  ///< s from the log's start,
  double duration = 0;  ///< of as many.
};

/// What a page asks of the player.
struct PlayerCommand {
  enum Kind { kPlay, kPause, kSeek, kSpeed };
  Kind kind = kPlay;
  double value = 0;  ///< kSeek: s from the start; kSpeed: times the log's own.
};

/// Serves the dashboard's page and, to at most kMaxViewers of them at a time, what is new, as
/// server-sent events:
///
///     reader --Take--> DashboardState <--Update-- one thread a viewer --socket--> page
///       ^------------------------- TakeCommands <--POST /control--------------------'
///
/// A viewer that takes nothing holds up its own thread alone: it misses what it was too slow for
/// (the charts' rows of a minute excepted), and after kPatience is let go. Nothing is sent while
/// the state is locked. Only requests that name this host are answered, and none that another
/// site's page made, so that no web site that the user visits reaches the session.
class DashboardServer {
 public:
  static constexpr int kMaxViewers = 16;
  static constexpr int kUpdatesPerSecond = 30;
  static constexpr std::chrono::seconds kPatience{10};

  /// Listens at once; `source` is the page's heading. A log's page has buttons for its player. The
  /// schemas name the channels' types and outlive the server.
  /// Throws MachineError where the address cannot be used.
  DashboardServer(const DashboardOptions& options, const std::string& source, bool is_log,
                  const MessageSchemas& schemas = MessageSchemas::Hpdm());
  /// Ends all connections at once.
  ~DashboardServer();
  DashboardServer(const DashboardServer&) = delete;
  DashboardServer& operator=(const DashboardServer&) = delete;

  /// "http://127.0.0.1:8090/": one that this machine's browsers can open.
  std::string address() const;
  int port() const { return port_; }

  /// The reader's thread.
  void Take(const LogEvent& event);
  void Set(const PlayerStatus& player);
  /// Messages that were not taken in time.
  void SetDropped(std::uint64_t messages);
  /// As of DashboardState.
  void Finish();
  void Interrupt();
  void Recall(const LogEvent& event);
  /// What pages asked for since the last call.
  std::vector<PlayerCommand> TakeCommands();

 private:
  bool Refuses(const httplib::Request& request, httplib::Response* response) const;
  void Control(const httplib::Request& request, httplib::Response* response);
  bool Stream(httplib::DataSink* sink);
  bool Write(std::string_view data, httplib::DataSink* sink) const;
  std::string StatusJson() const;
  bool stopping() const;

  DashboardOptions options_;
  std::string source_;
  bool is_log_;
  int port_ = 0;

  mutable std::mutex mutex_;  // of all that follows but the server
  std::condition_variable stopped_;
  bool stopping_ = false;
  int viewers_ = 0;
  DashboardState state_;
  std::optional<PlayerStatus> player_;
  std::uint64_t dropped_ = 0;
  std::chrono::steady_clock::time_point last_message_;
  std::vector<PlayerCommand> commands_;

  std::unique_ptr<RequestServer> server_;
  bool listening_ended_ = false;
  std::jthread listener_;
};

}  // namespace hpdm
