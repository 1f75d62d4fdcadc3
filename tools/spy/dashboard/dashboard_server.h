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
  int port = 8090;  ///< 0: any free port.
};

/// State of a log's player.
struct PlayerStatus {
  bool paused = false;
  bool ended = false;
  double speed = 1;
  double position = 0;  ///< s from the log's start.
  double duration = 0;  ///< s.
};

/// A page's request to the player.
struct PlayerCommand {
  enum Kind { kPlay, kPause, kSeek, kSpeed };
  Kind kind = kPlay;
  double value = 0;  ///< kSeek: s from the start; kSpeed: multiple of real time.
};

/// Serves the dashboard's page and sends updates as server-sent events to at most kMaxViewers
/// pages:
///
///     reader --Take--> DashboardState <--Update-- one thread a viewer --socket--> page
///       ^------------------------- TakeCommands <--POST /control--------------------'
///
/// A slow viewer delays only its own thread. It misses updates (except the charts' rows of the last
/// minute) and is disconnected after kPatience. Nothing is sent while the state is locked. Requests
/// must name this host and must not come from another site's page, so that no web site that the
/// user visits can reach the session.
class DashboardServer {
 public:
  static constexpr int kMaxViewers = 16;
  static constexpr int kUpdatesPerSecond = 30;
  static constexpr std::chrono::seconds kPatience{10};

  /// Starts to listen. `source` is the page's heading. A log's page has buttons for its player. The
  /// schemas name the channels' types and outlive the server. Throws MachineError if the address
  /// cannot be used.
  DashboardServer(const DashboardOptions& options, const std::string& source, bool is_log,
                  const MessageSchemas& schemas = MessageSchemas::Hpdm());
  /// Ends all connections at once.
  ~DashboardServer();
  DashboardServer(const DashboardServer&) = delete;
  DashboardServer& operator=(const DashboardServer&) = delete;

  /// Returns an address that this machine's browsers can open: "http://127.0.0.1:8090/".
  std::string address() const;
  int port() const { return port_; }

  /// Called by the reader's thread.
  void Take(const LogEvent& event);
  void Set(const PlayerStatus& player);
  /// Sets the number of messages that were not read in time.
  void SetDropped(std::uint64_t messages);
  /// As in DashboardState.
  void Finish();
  void Interrupt();
  void Recall(const LogEvent& event);
  /// Returns the pages' requests since the last call.
  std::vector<PlayerCommand> TakeCommands();

 private:
  void SetUpResponses();
  void SetUpPaths();
  void Listen();
  void SendMesh(int organ, httplib::Response* response);
  void SendEvents(httplib::Response* response);
  void Send(std::string text, const char* type, httplib::Response* response);
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

  mutable std::mutex mutex_;  // guards all that follows except the server
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
