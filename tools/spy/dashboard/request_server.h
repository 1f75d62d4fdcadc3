#pragma once

// After Eigen wherever both are included: it brings a macro _res.
#include <httplib.h>

#include <chrono>
#include <cstddef>
#include <mutex>
#include <set>

namespace hpdm {

/// An httplib::Server that serves one request a connection and closes it. So what a client sends
/// after a request that was refused with its body unread is never taken for another request; a
/// client has kRequestTime and kMaxRequestBytes for its request, however slowly or long it speaks;
/// and no idle connection holds a thread.
class RequestServer : public httplib::Server {
 public:
  static constexpr std::chrono::milliseconds kRequestTime{2000};
  static constexpr std::size_t kMaxRequestBytes = 64 << 10;
  /// How long a socket that takes nothing keeps one write waiting.
  static constexpr std::chrono::milliseconds kWriteTime{200};

  explicit RequestServer(std::chrono::milliseconds request_time = kRequestTime)
      : request_time_(request_time) {}

  /// Once bound: lets so many connections wait to be accepted. The library's five are fewer than a
  /// browser opens, and who finds no room tries again after a second.
  void LetWait(int connections);

  /// Ends every connection, also those that wait for a thread. Any thread; for good.
  void EndConnections();

 private:
  bool process_and_close_socket(socket_t socket) override;

  std::chrono::milliseconds request_time_;
  std::mutex mutex_;
  std::set<socket_t> open_;  // those that a thread serves
  bool ending_ = false;
};

}  // namespace hpdm
