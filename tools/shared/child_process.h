#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace hpdm {

/// Runs a program (a path, or a name to look up in PATH, and its arguments), without its output if
/// `quiet`, and waits for it. Its exit code; -1 when it ended in another way. Throws MachineError
/// (the program, why) when it cannot be started. Main thread, loops ended.
int RunChild(const std::vector<std::string>& words, bool quiet = true);

/// A program that runs beside this one, whose output is collected. No shell: the words reach it as
/// they are. It ends at the latest with the thread that started it, even where that is killed. Main
/// thread, loops ended.
class ChildProcess {
 public:
  /// As for RunChild; its standard input is empty.
  explicit ChildProcess(const std::vector<std::string>& words);
  /// Kills it if it still runs.
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// Waits at most `timeout_ms` until one of them has written or ended, and takes what is there.
  static void Poll(const std::vector<ChildProcess*>& children, int timeout_ms);
  /// It has closed its outputs: it has ended or is about to.
  bool silent() const { return out_.descriptor < 0 && err_.descriptor < 0; }
  /// The status as of waitpid, once it is silent and has ended.
  std::optional<int> Ended();
  /// Ends it and what it has started, and waits for it.
  void Kill();

  /// What it wrote so far, up to kMaxOutput of each; the rest is dropped.
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
