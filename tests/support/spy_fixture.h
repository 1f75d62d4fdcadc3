#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/scratch_folder.h"

// hpdm spy as people and scripts run it: the program itself.
namespace hpdm {

inline const std::string kSpyProgram = HPDM_BINARY_DIR "/tools/hpdm";

struct Ended {
  int code;
  std::string output, errors;
};
inline Ended RunSpy(const std::string& arguments, const ScratchFolder& folder) {
  const std::string errors = folder / "errors";
  const std::string command = kSpyProgram + " spy " + arguments + " 2> " + errors + " < /dev/null";
  std::FILE* pipe = popen(command.c_str(), "r");
  Ended ended{-1, {}, {}};
  char part[4096];
  for (std::size_t n = 0; (n = std::fread(part, 1, sizeof part, pipe)) > 0;) {
    ended.output.append(part, n);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status)) ended.code = WEXITSTATUS(status);
  std::ifstream file(errors);
  ended.errors = {std::istreambuf_iterator<char>(file), {}};
  return ended;
}

class SpyTest : public testing::Test {
 protected:
  static tool_t Tool(int i) {
    tool_t tool{};
    tool.sequence = i + 1;
    tool.tick = i;
    tool.tool_count = 1;
    tool.tools.resize(1);
    tool.tools[0].p_tip[0] = 0.25;
    tool.tools[0].p_tip[1] = std::sin(0.02 * i);
    return tool;
  }

  /// 20 s of a tool channel at 100 Hz, which lost three messages at 1 s, and of an unknown one.
  void WriteLog() {
    SessionLog log(log_, 1'700'000'000'000'000);
    event_t event{};
    event.name = "session.start";
    log.Write(kEventChannel, 0, EncodeMessage(event, &buffer_));
    for (int i = 0; i <= 2000; ++i) {
      if (i >= 100 && i < 103) continue;
      log.Write(kToolChannel, 10'000'000LL * i, EncodeMessage(Tool(i), &buffer_));
      if (i % 10 == 0) log.Write("FOREIGN", 10'000'000LL * i, foreign_);
    }
    event.name = "session.end";
    log.Write(kEventChannel, 20'000'000'000, EncodeMessage(event, &buffer_));
  }

  std::string SpyCommand(const std::string& arguments = "") const {
    return kSpyProgram + " spy " + log_ + ' ' + arguments;
  }

  const ScratchFolder folder_;
  const std::string log_ = folder_ / "session.lcmlog";
  std::vector<std::uint8_t> buffer_;
  std::vector<std::uint8_t> foreign_ = {1, 2, 3, 4, 5, 6, 7, 8, 9};
};

}  // namespace hpdm
