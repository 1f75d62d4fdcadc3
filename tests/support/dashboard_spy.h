#pragma once

#include <chrono>
#include <fstream>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/read_file.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/virtual_display.h"

namespace hpdm {

/// `hpdm spy ... --web` as a process of its own.
class Spy {
 public:
  /// The arguments of `hpdm spy`.
  struct Arguments {
    std::string text;
  };
  /// `port` 0: any free one. `log` empty: live. `options`: further ones.
  explicit Spy(const std::string& log, int port = 0, const std::string& options = "")
      : Spy(Arguments{log + " --web " + std::to_string(port) + " " + options}) {}
  explicit Spy(const Arguments& arguments) {
    output_ = folder_ / "output";
    const std::string command = std::string("exec ") + HPDM_BINARY_DIR + "/tools/hpdm spy " +
                                arguments.text + " >" + output_ + " 2>" + (folder_ / "errors");
    child_.emplace(std::vector<std::string>{"sh", "-c", command});
    // The line is complete when it has its end.
    for (int i = 0; i < 200 && address_.empty() && errors().empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
      const std::string text = ReadFile(output_);
      const std::size_t at = text.find("http://");
      if (at != std::string::npos && text.find('\n', at) != std::string::npos) {
        address_ = text.substr(at, text.find_first_of(" \n", at) - at);
      }
    }
  }
  /// "http://127.0.0.1:40123/"; empty where it did not start.
  const std::string& address() const { return address_; }
  int port() const { return std::stoi(address_.substr(address_.rfind(':') + 1)); }
  std::string errors() const { return ReadFile(folder_ / "errors"); }
  Child& child() { return *child_; }

 private:
  ScratchFolder folder_;
  std::string output_, address_;
  std::optional<Child> child_;
};

/// Three seconds of two hands on one liver, both in contact.
inline const std::string& TwoHandsLog() {
  static const ScratchFolder folder;
  static const std::string path = [] {
    const std::string log = folder / "session.lcmlog";
    Record({.scene = HPDM_SOURCE_DIR "/scenes/two_hands.toml",
            .log = log,
            .ticks = 3000,
            .hand_lead_ms = 900});
    return log;
  }();
  return path;
}

}  // namespace hpdm
