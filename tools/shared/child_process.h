#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace hpdm {

/// Runs a program (a path or a name in PATH, then its arguments) and waits for it. `quiet` discards
/// its output. Returns its exit code, or -1 if it ended in another way. Throws MachineError
/// (program, reason) if it cannot be started. Main thread, after the loops have ended.
int RunChild(const std::vector<std::string>& words, bool quiet = true);

/// A program that runs beside this one and whose output is collected. The words are passed without
/// a shell. It ends at the latest with the thread that started it, even if that is killed. Main
/// thread, after the loops have ended.
class ChildProcess {
 public:
  /// Starts the program as RunChild does, with empty standard input.
  explicit ChildProcess(const std::vector<std::string>& words);
  /// Kills the program if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits at most `timeout_ms` until one child has written or ended, and reads the available
  /// output.
  static void Poll(const std::vector<ChildProcess*>& children, int timeout_ms);
  /// True if it has closed its outputs: it has ended or is about to end.
  bool silent() const { return out_.descriptor < 0 && err_.descriptor < 0; }
  /// Returns the waitpid status once the program is silent and has ended.
  std::optional<int> Ended();
  /// Kills the program and everything it started, and waits for it.
  void Kill();

  /// Output so far, up to kMaxOutput per stream; the rest is dropped.
  const std::string& out() const { return out_.text; }
  const std::string& err() const { return err_.text; }
  bool too_much() const { return out_.too_much; }
  static constexpr std::size_t kMaxOutput = 64 << 20;

 private:
  struct Pipe {
    int descriptor = -1;
    std::string text;
    bool too_much = false;
    void Take();
    void Close();
  };

  pid_t child_ = -1;
  Pipe out_;
  Pipe err_;
};

}  // namespace hpdm
