#pragma once

// Include it after Eigen: it defines a macro _res.
#include <httplib.h>

#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>

namespace hpdm {

/// An httplib::Server that serves one request per connection and closes it:
///   - the unread body of a refused request is never taken for another request;
///   - a client has kRequestTime and kMaxRequestBytes for its request;
///   - an idle connection occupies no thread.
class RequestServer : public httplib::Server {
 public:
  static constexpr std::chrono::milliseconds kRequestTime{2000};
  static constexpr std::size_t kMaxRequestBytes = 64 << 10;
  /// Longest wait of a write for a socket that takes nothing.
  static constexpr std::chrono::milliseconds kWriteTime{200};

  explicit RequestServer(std::chrono::milliseconds request_time = kRequestTime)
      : request_time_(request_time) {}

  /// Sets how many connections may wait to be accepted. Call after binding. A browser opens more
  /// than the library's five, and a refused connection tries again only after a second.
  void LetWait(int connections);
  /// Closes all connections, including those that still wait for a thread. Any thread.
  void EndConnections();

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::chrono::milliseconds request_time_;
  std::mutex mutex_;
  std::set<socket_t> open_;  // sockets that a thread serves
  bool ending_ = false;
};

}  // namespace hpdm
