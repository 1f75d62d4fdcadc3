#include "tools/spy/dashboard/request_server.h"

#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <string>

namespace hpdm {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

// Time for which the rest of a client's bytes is read: closing a socket with unread bytes resets
// the connection, and the client may lose the answer.
constexpr milliseconds kParting{250};

/// True if the socket is ready for `events` before `end`; false if both directions are closed.
bool Wait(int socket, short events, steady_clock::time_point end) {
  for (;;) {
    const auto left = std::chrono::ceil<milliseconds>(end - steady_clock::now()).count();
    pollfd poller = {socket, events, 0};
    const int ready = poll(&poller, 1, static_cast<int>(std::max<milliseconds::rep>(left, 0)));
    if (ready > 0) return (poller.revents & events) != 0 && (poller.revents & POLLERR) == 0;
    if (ready == 0 || errno != EINTR) return false;
  }
}

/// The stream of a connection for httplib.
class Connection : public httplib::Stream {
 public:
  Connection(int socket, milliseconds request_time)
      : socket_(socket), read_until_(steady_clock::now() + request_time) {}

  bool is_readable() const override { return at_ < end_ || Wait(socket_, POLLIN, read_until_); }
  bool is_writable() const override {
    return Wait(socket_, POLLOUT, steady_clock::now() + RequestServer::kWriteTime);
  }

  // httplib asks for one byte at a time.
  ssize_t read(char* data, std::size_t size) override {
    if (at_ == end_) {
      if (left_ == 0 || steady_clock::now() > read_until_ || !is_readable()) return -1;
      const ssize_t got = recv(socket_, buffer_.data(), std::min(buffer_.size(), left_), 0);
      if (got <= 0) return got;
      at_ = 0;
      end_ = static_cast<std::size_t>(got);
      left_ -= end_;
    }
    const std::size_t count = std::min(size, end_ - at_);
    std::memcpy(data, buffer_.data() + at_, count);
    at_ += count;
    return static_cast<ssize_t>(count);
  }
  ssize_t write(const char* data, std::size_t size) override {
    return is_writable() ? send(socket_, data, size, MSG_NOSIGNAL | MSG_DONTWAIT) : -1;
  }

  void get_remote_ip_and_port(std::string& ip, int& port) const override {
    Name(getpeername, &ip, &port);
  }
  void get_local_ip_and_port(std::string& ip, int& port) const override {
    Name(getsockname, &ip, &port);
  }
  socket_t socket() const override { return socket_; }

 private:
  template <typename Get>
  void Name(Get get, std::string* ip, int* port) const {
    sockaddr_storage address{};
    socklen_t size = sizeof address;
    char host[NI_MAXHOST], service[NI_MAXSERV];
    auto* any = reinterpret_cast<sockaddr*>(&address);
    if (get(socket_, any, &size) != 0 ||
        getnameinfo(any, size, host, sizeof host, service, sizeof service,
                    NI_NUMERICHOST | NI_NUMERICSERV) != 0) {
      return;
    }
    *ip = host;
    *port = std::stoi(service);
  }

  int socket_;
  steady_clock::time_point read_until_;
  std::size_t left_ = RequestServer::kMaxRequestBytes;
  std::array<char, 4096> buffer_;
  std::size_t at_ = 0, end_ = 0;  // its unread part
};

void Part(int socket) {
  shutdown(socket, SHUT_WR);
  const auto end = steady_clock::now() + kParting;
  std::array<char, 4096> rest;
  std::size_t left = RequestServer::kMaxRequestBytes;
  while (left > 0 && Wait(socket, POLLIN, end)) {
    const ssize_t got = recv(socket, rest.data(), std::min(rest.size(), left), 0);
    if (got <= 0) return;
    left -= static_cast<std::size_t>(got);
  }
}

}  // namespace

bool RequestServer::process_and_close_socket(socket_t socket) {
  {
    const std::lock_guard lock(mutex_);
    if (ending_) {
      close(socket);
      return false;
    }
    open_.insert(socket);
  }
  Connection connection(socket, request_time_);
  bool closed = false;
  const bool served = process_request(connection, true, closed, nullptr);
  Part(socket);
  const std::lock_guard lock(mutex_);  // so that no reused socket number is shut down
  open_.erase(socket);
  close(socket);
  return served;
}

void RequestServer::LetWait(int connections) { ::listen(svr_sock_, connections); }

void RequestServer::EndConnections() {
  const std::lock_guard lock(mutex_);
  ending_ = true;
  for (const socket_t socket : open_) shutdown(socket, SHUT_RDWR);
}

}  // namespace hpdm
