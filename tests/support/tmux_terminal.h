#pragma once

#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>

namespace hpdm {

/// Returns the output of a shell command.
inline std::string OutputOf(const std::string& command) {
  std::string output;
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return output;
  char part[4096];
  for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe)) > 0;) output.append(part, n);
  pclose(pipe);
  return output;
}

/// A tmux terminal that runs a shell command, shows its exit code as "RC=n" and stays open. Its
/// screen is the one that a person would see.
class TmuxTerminal {
 public:
  static bool Installed() { return std::system("tmux -V > /dev/null 2>&1") == 0; }

  TmuxTerminal(const std::string& command, int columns, int rows)
      : tmux_("tmux -L hpdm_test_" + std::to_string(getpid()) + '_' + std::to_string(++count_) +
              " -f /dev/null ") {
    Run("new-session -d -x " + std::to_string(columns) + " -y " + std::to_string(rows) + " '" +
        command + "; echo RC=$?; sleep 1000'");
  }
  ~TmuxTerminal() { Run("kill-server"); }
  TmuxTerminal(const TmuxTerminal&) = delete;
  TmuxTerminal& operator=(const TmuxTerminal&) = delete;

  /// Keys in tmux's names: "j", "Enter", "Escape", "Right".
  void Press(const std::string& keys) { Run("send-keys " + keys); }
  void Resize(int columns, int rows) {
    Run("resize-window -x " + std::to_string(columns) + " -y " + std::to_string(rows));
  }
  std::string Screen() const { return OutputOf(tmux_ + "capture-pane -p 2> /dev/null"); }

  /// Waits until the screen is as wanted; the last one seen.
  std::string WaitFor(const std::function<bool(const std::string&)>& wanted) const {
    // The limit is for a loaded machine; usual times are far shorter.
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    std::string screen = Screen();
    while (!wanted(screen) && std::chrono::steady_clock::now() < end) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      screen = Screen();
    }
    return screen;
  }
  std::string WaitFor(const std::string& text) const {
    return WaitFor([&](const std::string& screen) { return screen.find(text) != screen.npos; });
  }

 private:
  void Run(const std::string& command) const {
    [[maybe_unused]] const int status =
        std::system((tmux_ + command + " > /dev/null 2>&1").c_str());
  }

  static inline int count_ = 0;  // a server each: one that ends may still hold its name
  std::string tmux_;
};

}  // namespace hpdm
