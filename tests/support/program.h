#pragma once

#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>

#include "tests/support/read_file.h"

/// Programs as a user starts them, for tests.
namespace hpdm {

inline const std::filesystem::path kSource = HPDM_SOURCE_DIR;
inline const std::string kHpdmProgram = std::string(HPDM_BINARY_DIR) + "/tools/hpdm";
inline const std::filesystem::path kScenes = std::filesystem::path(HPDM_SOURCE_DIR) / "scenes";

/// How a program ended and what it wrote.
struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

inline bool Becomes(const std::function<bool()>& condition,
                    std::chrono::seconds patience = std::chrono::seconds(20)) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

/// How many times `part` occurs.
inline int Count(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) {
    ++count;
  }
  return count;
}

/// A shell command that runs beside the test, in a process group of its own, its output in files.
/// Killed with all its children at the end.
class BackgroundCommand {
 public:
  BackgroundCommand(const std::string& command, std::string out, std::string err)
      : out_(std::move(out)), err_(std::move(err)) {
    const std::string line = "exec </dev/null >" + out_ + " 2>" + err_ + "; " + command;
    pid_ = fork();
    if (pid_ == 0) {
      setpgid(0, 0);
      execl("/bin/sh", "sh", "-c", line.c_str(), nullptr);
      _exit(127);
    }
    setpgid(pid_, pid_);
  }
  ~BackgroundCommand() {
    if (pid_ > 0) Signal(SIGKILL);
    Wait();
  }
  BackgroundCommand(const BackgroundCommand&) = delete;
  BackgroundCommand& operator=(const BackgroundCommand&) = delete;

  /// Signals the whole process group.
  void Signal(int signal) const { kill(-pid_, signal); }
  /// The exit status, or -1.
  int Wait() {
    if (pid_ <= 0) return exit_;
    int status = 0;
    rusage usage{};
    wait4(pid_, &status, 0, &usage);
    pid_ = 0;
    peak_kb_ = usage.ru_maxrss;
    return exit_ = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  /// Largest memory use, kB; valid after Wait.
  long peak_kb() const { return peak_kb_; }
  std::string out() const { return ReadFile(out_); }
  std::string err() const { return ReadFile(err_); }

 private:
  std::string out_, err_;
  pid_t pid_ = 0;
  int exit_ = -1;
  long peak_kb_ = 0;
};

/// Runs a shell command to its end; its exit status, or -1.
inline int Shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace hpdm
