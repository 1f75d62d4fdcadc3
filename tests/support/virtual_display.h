#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace hpdm {

/// A child process, ended with its owner.
class Child {
 public:
  explicit Child(const std::vector<std::string>& argv) {
    pid_ = fork();
    if (pid_ != 0) return;
    std::vector<char*> arguments;
    for (const std::string& a : argv) arguments.push_back(const_cast<char*>(a.c_str()));
    arguments.push_back(nullptr);
    execvp(arguments[0], arguments.data());
    _exit(127);
  }
  ~Child() { End(SIGKILL); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void End(int signal) {
    if (pid_ <= 0) return;
    kill(pid_, signal);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  void Signal(int signal) const { kill(pid_, signal); }
  /// The exit code, or -1 when it has not ended by itself within `seconds`.
  int Wait(double seconds) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    int status = 0;
    while (std::chrono::steady_clock::now() < end) {
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return -1;
  }

 private:
  pid_t pid_ = -1;
};

/// An X server without a screen, on a free display that it chooses itself, named in DISPLAY for
/// the children that are started while it lives.
class VirtualDisplay {
 public:
  /// name() is empty where Xvfb is missing or does not start.
  VirtualDisplay() {
    int ends[2] = {-1, -1};
    if (pipe(ends) != 0) return;
    // Without -noreset it starts over, and refuses clients, whenever the last one has left.
    server_.emplace(std::vector<std::string>{"Xvfb", "-displayfd", std::to_string(ends[1]),
                                             "-screen", "0", "1280x1024x24", "-nolisten", "tcp",
                                             "-noreset"});
    close(ends[1]);
    // The server closes its end when it fails, which ends the read.
    char digit;
    while (read(ends[0], &digit, 1) == 1 && digit != '\n') name_ += digit;
    close(ends[0]);
    if (name_.empty()) return;
    name_ = ":" + name_;
    setenv("DISPLAY", name_.c_str(), 1);
  }
  ~VirtualDisplay() {
    End();
    unsetenv("DISPLAY");
  }

  const std::string& name() const { return name_; }
  /// Ends the server with a signal that lets it remove its lock file; its clients lose their
  /// display.
  void End() {
    if (server_) server_->End(SIGTERM);
  }

 private:
  std::optional<Child> server_;
  std::string name_;
};

}  // namespace hpdm
