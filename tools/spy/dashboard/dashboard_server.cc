#include "tools/spy/dashboard/dashboard_server.h"

#include <netinet/tcp.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/base/error.h"
#include "lcmtypes/live/wall_time.h"
#include "tools/spy/dashboard/request_origin.h"
#include "tools/spy/dashboard/request_server.h"
#include "tools/web/web_pages.h"

namespace hpdm {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr std::chrono::microseconds kInterval{1'000'000 / DashboardServer::kUpdatesPerSecond + 1};
// A page reports a lost connection after three missing heartbeats.
constexpr milliseconds kHeartbeat{1000};
constexpr std::size_t kPiece = 16 << 10;
constexpr std::size_t kMaxCommands = 64;
// Threads for requests other than the viewers' streams.
constexpr int kFurtherThreads = 8;
constexpr int kMaxWaiting = 128;

// Keeps the system's buffers small, so that a slow viewer gets recent data, and so that writing a
// piece to a writable socket does not block. Sockets inherit the options from their listener. The
// library's default SO_REUSEPORT is left out: with it two servers would share a port.
void SetSocketOptions(socket_t socket) {
  const int yes = 1, waiting = 4 * kPiece, buffer = 16 * kPiece;
  setsockopt(socket, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
  setsockopt(socket, IPPROTO_TCP, TCP_NOTSENT_LOWAT, &waiting, sizeof waiting);
}

}  // namespace

DashboardServer::DashboardServer(const DashboardOptions& options, const std::string& source,
                                 bool is_log, const MessageSchemas& schemas)
    : options_(options),
      source_(source),
      is_log_(is_log),
      state_(schemas),
      last_message_(steady_clock::now()),
      server_(std::make_unique<RequestServer>()) {
  server_->set_socket_options(SetSocketOptions);
  server_->set_tcp_nodelay(true);
  server_->set_payload_max_length(4096);
  server_->new_task_queue = [] { return new httplib::ThreadPool(kMaxViewers + kFurtherThreads); };
  SetUpResponses();
  SetUpPaths();
  Listen();
}

void DashboardServer::SetUpResponses() {
  server_->set_default_headers(
      {{"Content-Security-Policy",
        "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
        "connect-src 'self'; img-src data: blob:; base-uri 'none'; form-action 'none'; "
        "frame-ancestors 'none'"},
       {"X-Content-Type-Options", "nosniff"},
       {"Referrer-Policy", "no-referrer"},
       {"Cross-Origin-Resource-Policy", "same-origin"},
       {"Cache-Control", "no-store"}});
  server_->set_pre_routing_handler([this](const httplib::Request& request, httplib::Response& out) {
    return Refuses(request, &out) ? httplib::Server::HandlerResponse::Handled
                                  : httplib::Server::HandlerResponse::Unhandled;
  });
}

void DashboardServer::SetUpPaths() {
  server_->Get("/", [this](const httplib::Request&, httplib::Response& out) {
    Send(std::string(DashboardPage()), "text/html; charset=utf-8", &out);
  });
  server_->Get("/favicon.ico",
               [](const httplib::Request&, httplib::Response& out) { out.status = 204; });
  server_->Get(R"(/mesh/(\d{1,4}))",
               [this](const httplib::Request& request, httplib::Response& out) {
                 SendMesh(std::stoi(request.matches[1]), &out);
               });
  server_->Get("/events",
               [this](const httplib::Request&, httplib::Response& out) { SendEvents(&out); });
  server_->Post("/control", [this](const httplib::Request& request, httplib::Response& out) {
    Control(request, &out);
  });
}

void DashboardServer::Listen() {
  errno = 0;
  if (options_.port == 0) {
    port_ = server_->bind_to_any_port(options_.host);
  } else if (server_->bind_to_port(options_.host, options_.port)) {
    port_ = options_.port;
  }
  if (port_ <= 0) {
    const bool in_use = errno == EADDRINUSE;
    throw MachineError("--web " + std::to_string(options_.port) + ": " +
                       (in_use ? "the port is in use; choose another, or 0 for any free port"
                               : "cannot listen on " + options_.host +
                                     "; give --host an address of this machine and a port from "
                                     "1024 on"));
  }
  server_->LetWait(kMaxWaiting);
  listener_ = std::jthread([this] {
    server_->listen_after_bind();
    const std::lock_guard lock(mutex_);
    listening_ended_ = true;
  });
}

DashboardServer::~DashboardServer() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_all();
  // stop() has no effect before the server listens.
  const auto listens_or_ended = [this] {
    const std::lock_guard lock(mutex_);
    return server_->is_running() || listening_ended_;
  };
  while (!listens_or_ended()) std::this_thread::sleep_for(milliseconds(1));
  server_->stop();
  server_->EndConnections();
  listener_.join();
}

std::string DashboardServer::address() const {
  std::string host = options_.host;
  if (IsAllAddresses(host)) host = host == "::" ? "::1" : "127.0.0.1";
  return "http://" + (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
         std::to_string(port_) + "/";
}

void DashboardServer::Send(std::string text, const char* type, httplib::Response* response) {
  const std::size_t size = text.size();
  response->set_content_provider(
      size, type,
      [this, text = std::move(text)](std::size_t at, std::size_t bytes, httplib::DataSink& sink) {
        return Write(std::string_view(text).substr(at, bytes), &sink);
      });
}

void DashboardServer::SendMesh(int organ, httplib::Response* response) {
  std::string text;
  {
    const std::lock_guard lock(mutex_);
    text = state_.MeshJson(organ);
  }
  if (text.empty()) {
    response->status = 404;
  } else {
    Send(std::move(text), "application/json", response);
  }
}

void DashboardServer::SendEvents(httplib::Response* response) {
  {
    const std::lock_guard lock(mutex_);
    if (viewers_ >= kMaxViewers) {
      response->status = 503;
      response->set_content("too many viewers", "text/plain");
      return;
    }
    ++viewers_;
  }
  response->set_content_provider(
      "text/event-stream", [this](std::size_t, httplib::DataSink& sink) { return Stream(&sink); },
      [this](bool) {
        const std::lock_guard lock(mutex_);
        --viewers_;
      });
}

bool DashboardServer::Refuses(const httplib::Request& request, httplib::Response* response) const {
  const std::string host = request.get_header_value("Host");
  const std::string origin = request.get_header_value("Origin");
  const std::string site = request.get_header_value("Sec-Fetch-Site");
  const bool own = (origin.empty() || SameHost(origin, "http://" + host)) &&
                   (site.empty() || site == "same-origin" || site == "none");
  // A link on another site may open the page itself.
  const bool opens = request.method == "GET" && request.path == "/" && origin.empty();
  if (MeansThisServer(host, options_.host) && (own || opens)) return false;
  response->status = 403;
  response->set_content("refused: the request is for another host or from another site",
                        "text/plain");
  return true;
}

void DashboardServer::Control(const httplib::Request& request, httplib::Response* response) {
  response->status = 400;
  if (!is_log_ || !request.get_header_value("Content-Type").starts_with("application/json")) return;
  const json asked = json::parse(request.body, nullptr, false);
  if (!asked.is_object() || !asked.contains("command") || !asked["command"].is_string()) return;
  const std::string name = asked["command"];
  const bool has_value = asked.contains("value") && asked["value"].is_number();
  PlayerCommand command;
  command.value = has_value ? asked["value"].get<double>() : 0;
  if (name == "play") {
    command.kind = PlayerCommand::kPlay;
  } else if (name == "pause") {
    command.kind = PlayerCommand::kPause;
  } else if (name == "seek" && has_value && command.value >= 0) {
    command.kind = PlayerCommand::kSeek;
  } else if (name == "speed" && has_value && command.value > 0) {
    command.kind = PlayerCommand::kSpeed;
  } else {
    return;
  }
  const std::lock_guard lock(mutex_);
  if (commands_.size() >= kMaxCommands) return;
  commands_.push_back(command);
  response->status = 204;
}

bool DashboardServer::Stream(httplib::DataSink* sink) {
  DashboardState::Seen seen;
  auto next = steady_clock::now();
  auto last_sent = next - kHeartbeat;
  std::string text, status, sent_status;
  if (!Write("retry: 500\n\n", sink)) return false;
  for (;;) {
    std::string members;
    {
      std::unique_lock lock(mutex_);
      if (stopped_.wait_until(lock, next, [this] { return stopping_; })) return false;
      const std::int64_t now_us = is_log_ ? state_.newest_us() : WallTimeUs();
      members = state_.Update(now_us, &seen);
      status = StatusJson();
    }
    const auto now = steady_clock::now();
    next = std::max(next + kInterval, now);
    const bool changed = !members.empty() || (is_log_ && status != sent_status);
    if (!changed && now - last_sent < kHeartbeat) continue;
    text = "data: {\"status\":" + status + (members.empty() ? "" : ",") + members + "}\n\n";
    if (!Write(text, sink)) return false;
    last_sent = now;
    sent_status.swap(status);
  }
}

bool DashboardServer::Write(std::string_view data, httplib::DataSink* sink) const {
  auto last = steady_clock::now();
  while (!data.empty()) {
    const auto before = steady_clock::now();
    if (stopping()) return false;
    if (!sink->is_writable()) {
      const auto now = steady_clock::now();
      // A sink that refuses data without waiting has lost its viewer. A sink that waits first has a
      // slow viewer, which gets kPatience.
      if (now - before < RequestServer::kWriteTime / 2 || now - last > kPatience) return false;
      continue;
    }
    const std::string_view piece = data.substr(0, kPiece);
    if (!sink->write(piece.data(), piece.size())) return false;
    data.remove_prefix(piece.size());
    last = steady_clock::now();
  }
  return true;
}

std::string DashboardServer::StatusJson() const {
  json status = {{"source", source_}, {"messages", state_.messages()}, {"dropped", dropped_}};
  if (state_.two_sessions()) status["two_sessions"] = true;
  if (is_log_) {
    const PlayerStatus player = player_.value_or(PlayerStatus());
    status["player"] = {{"paused", player.paused},
                        {"ended", player.ended},
                        {"speed", player.speed},
                        {"position", player.position},
                        {"duration", player.duration}};
  } else {
    status["silent_s"] = std::chrono::duration<double>(steady_clock::now() - last_message_).count();
  }
  return status.dump(-1, ' ', false, json::error_handler_t::replace);
}

bool DashboardServer::stopping() const {
  const std::lock_guard lock(mutex_);
  return stopping_;
}

void DashboardServer::Take(const LogEvent& event) {
  const std::lock_guard lock(mutex_);
  state_.Take(event);
  last_message_ = steady_clock::now();
}

void DashboardServer::Set(const PlayerStatus& player) {
  const std::lock_guard lock(mutex_);
  player_ = player;
}

void DashboardServer::SetDropped(std::uint64_t messages) {
  const std::lock_guard lock(mutex_);
  dropped_ = messages;
}

void DashboardServer::Finish() {
  const std::lock_guard lock(mutex_);
  state_.Finish();
}

void DashboardServer::Interrupt() {
  const std::lock_guard lock(mutex_);
  state_.Interrupt();
}

void DashboardServer::Recall(const LogEvent& event) {
  const std::lock_guard lock(mutex_);
  state_.Recall(event);
}

std::vector<PlayerCommand> DashboardServer::TakeCommands() {
  const std::lock_guard lock(mutex_);
  return std::exchange(commands_, {});
}

}  // namespace hpdm
