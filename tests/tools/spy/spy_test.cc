#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <thread>
#include <utility>

#include "lcmtypes/analysis/log_health.h"
#include "lcmtypes/live/network.h"
#include "tests/support/network_namespace.h"
#include "tests/support/recorded_session.h"
#include "tests/support/spy_fixture.h"
#include "tests/support/tmux_terminal.h"

// hpdm spy in a terminal of its own.
namespace hpdm {
namespace {

/// The words of the screen's line that begins with `name`.
std::vector<std::string> LineOf(const std::string& screen, const std::string& name) {
  std::istringstream lines(screen);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(name + ' ')) continue;
    std::istringstream words(line);
    return {std::istream_iterator<std::string>(words), {}};
  }
  return {};
}

std::string WithoutCommas(std::string number) {
  std::erase(number, ',');
  return number;
}

#define REQUIRE_TMUX() \
  if (!TmuxTerminal::Installed()) GTEST_SKIP() << "tmux is not installed"

TEST_F(SpyTest, TheTableShowsEveryChannelOfASessionWithItsCounts) {
  REQUIRE_TMUX();
  Recording recording;
  recording.scene = HPDM_SOURCE_DIR "/scenes/two_hands.toml";
  recording.log = log_;
  recording.ticks = 1100;
  Record(recording);
  const LogHealth health = CheckLog(log_, MessageSchemas::Hpdm());
  const TmuxTerminal terminal(SpyCommand("--speed 100"), 80, 24);
  const std::string screen = terminal.WaitFor("■");
  ASSERT_GE(health.channels.size(), 7u);
  for (const ChannelFacts& channel : health.channels) {
    const std::vector<std::string> words = LineOf(screen, channel.channel);
    ASSERT_GE(words.size(), 7u) << screen;
    EXPECT_EQ(words[1], channel.type);
    EXPECT_EQ(WithoutCommas(words[2]), std::to_string(channel.messages)) << screen;
    EXPECT_EQ(words[words.size() - 2], "0") << "lost";
    EXPECT_EQ(words.back(), "0") << "unreadable";
  }
  EXPECT_EQ(LineOf(screen, kToolChannel)[3], "1000") << screen;
}

TEST_F(SpyTest, LossesAndUnknownTypesAreShown) {
  REQUIRE_TMUX();
  WriteLog();
  const TmuxTerminal terminal(SpyCommand("--speed 100"), 100, 24);
  const std::string screen = terminal.WaitFor("■");
  const std::vector<std::string> tool = LineOf(screen, kToolChannel);
  ASSERT_GE(tool.size(), 7u) << screen;
  EXPECT_EQ(tool[2], "1,998");
  EXPECT_EQ(tool[tool.size() - 2], "3");
  EXPECT_EQ(LineOf(screen, "FOREIGN")[1], "0x0102030405060708") << screen;
}

TEST_F(SpyTest, EnterShowsValuesWithSparklinesAndEscapeGoesBack) {
  REQUIRE_TMUX();
  WriteLog();
  TmuxTerminal terminal(SpyCommand("--speed 5"), 80, 24);
  terminal.WaitFor("HPDM_TOOL");
  terminal.Press("G Enter");  // the last one by name
  const std::string screen = terminal.WaitFor([](const std::string& s) {
    const std::size_t at = s.find("tools[0].p_tip[1]");
    return at != s.npos && s.find("█", at) != s.npos && s.find("▁", at) != s.npos;
  });
  EXPECT_NE(screen.find("hpdm.tool_t"), screen.npos) << screen;
  EXPECT_EQ(LineOf(screen, "tools[0].p_tip[0]")[1], "0.25") << screen;
  EXPECT_NE(screen.find("LAST 10 s"), screen.npos);
  EXPECT_NE(screen.find("█"), screen.npos) << screen;
  terminal.Press("/ v _ t i p Enter");
  const std::string filtered = terminal.WaitFor("[/v_tip]");
  EXPECT_NE(filtered.find("tools[0].v_tip[2]"), filtered.npos) << filtered;
  EXPECT_EQ(filtered.find("tools[0].p_tip[0]"), filtered.npos) << filtered;
  terminal.Press("Escape");
  terminal.WaitFor("tools[0].joints");
  terminal.Press("Escape");
  EXPECT_NE(terminal.WaitFor("FOREIGN").find("CHANNEL"), std::string::npos);
  terminal.Press("Escape");  // leads back no further, and not out
  terminal.Press("?");
  EXPECT_NE(terminal.WaitFor("any other key: back").find("page, first, last"), std::string::npos);
}

TEST_F(SpyTest, ManyValuesAreOneRowUntilTheyAreOpened) {
  REQUIRE_TMUX();
  {
    SessionLog log(log_, 0);
    organ_t organ{};
    organ.value_count = 600;
    organ.displacements.resize(600);
    for (int i = 0; i < 5; ++i) {
      log.Write(kOrganChannel, 100'000'000LL * i, EncodeMessage(organ, &buffer_));
    }
  }
  TmuxTerminal terminal(SpyCommand(), 80, 24);
  terminal.WaitFor("HPDM_ORGAN");
  terminal.Press("Enter");
  terminal.WaitFor("displacements: 600 values");
  terminal.Press("G Enter");
  terminal.Press("G");
  EXPECT_NE(terminal.WaitFor("displacements[599]").find("displacements[599]"), std::string::npos);
}

TEST_F(SpyTest, SeeksAndSpeedMoveThePosition) {
  REQUIRE_TMUX();
  WriteLog();
  TmuxTerminal terminal(SpyCommand(), 80, 24);
  terminal.WaitFor("▶ 1x");
  terminal.Press("Space");
  terminal.WaitFor("‖ 1x");
  const auto stands_at = [&](const std::string& time) {
    const std::string screen = terminal.WaitFor(' ' + time + ' ');
    EXPECT_NE(screen.find(' ' + time + ' '), screen.npos) << screen;
  };
  terminal.Press("5");
  stands_at("0:10.0");
  terminal.Press("Right");
  stands_at("0:15.0");
  terminal.Press("Left Left");
  stands_at("0:05.0");
  // Events before the position are shown although the play is paused: a second and a half.
  EXPECT_NEAR(std::stod(LineOf(terminal.Screen(), kToolChannel)[3]), 100, 1);
  terminal.Press("Home");
  stands_at("0:00.0");
  terminal.Press("+ + Space");
  terminal.WaitFor("▶ 5x");
  terminal.Press("-");
  terminal.WaitFor("▶ 2x");
  terminal.Press("End");
  terminal.WaitFor("■");
  stands_at("0:20.0");
  terminal.Press("Space");  // from the start
  const std::string screen = terminal.WaitFor("▶ 2x");
  EXPECT_NE(screen.find("▶ 2x   0:0"), screen.npos) << screen;
  terminal.Press("Space");
  terminal.WaitFor("‖");
  // A rare channel shows its last message before the position, not a later one seen earlier.
  const auto shows = [&](const std::string& name) {
    const std::string seen = terminal.WaitFor(name);
    EXPECT_NE(seen.find(name), seen.npos) << seen;
  };
  terminal.Press("End");
  terminal.WaitFor("■");
  terminal.Press("5");
  stands_at("0:10.0");
  terminal.Press("g Down Enter");
  shows("session.start");
  terminal.Press("End");
  shows("session.end");
  terminal.Press("3");
  shows("session.start");
}

TEST_F(SpyTest, AResizedTerminalShowsWhatANewOneOfThatSizeDoes) {
  REQUIRE_TMUX();
  WriteLog();
  const std::string command = SpyCommand("--from 10");
  const auto pause_at_half = [](TmuxTerminal* terminal) {
    terminal->WaitFor("▶");
    terminal->Press("Space");
    terminal->WaitFor("‖");
    terminal->Press("5");
    terminal->WaitFor("0:10.0");
  };
  for (const bool fields : {false, true}) {
    // Names and the time line: counts differ by what was played before the pause.
    const auto names = [](const std::string& screen) {
      std::string left;
      std::istringstream lines(screen);
      for (std::string line; std::getline(lines, line);) left += line.substr(0, 12) + '\n';
      return left;
    };
    const std::string second_line = fields ? "\nHPDM_TOOL" : "\nCHANNEL";
    const auto drawn_in = [&second_line](int rows) {
      return [rows, &second_line](const std::string& screen) {
        const std::size_t foot = screen.rfind("? help");
        // A shrunk terminal keeps its last rows until it is redrawn.
        return screen.find(second_line) == screen.find('\n') &&
               std::count(screen.begin(), screen.end(), '\n') == rows &&
               screen.find("0:10.0") != screen.npos && foot != screen.npos &&
               std::count(screen.begin(), screen.begin() + static_cast<std::ptrdiff_t>(foot),
                          '\n') == rows - 1;
      };
    };
    const std::vector<std::pair<int, int>> sizes = {{40, 12}, {120, 40}, {20, 6}, {80, 24}};
    std::vector<std::string> resized;
    TmuxTerminal terminal(command, 100, 30);
    pause_at_half(&terminal);
    if (fields) terminal.Press("G Enter");
    terminal.WaitFor(fields ? "FIELD" : "CHANNEL");
    for (const auto& [columns, rows] : sizes) {
      terminal.Resize(columns, rows);
      resized.push_back(terminal.WaitFor(drawn_in(rows)));
      EXPECT_TRUE(drawn_in(rows)(resized.back())) << resized.back();
    }
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      TmuxTerminal fresh(command, sizes[i].first, sizes[i].second);
      pause_at_half(&fresh);
      if (fields) fresh.Press("G Enter");
      const std::string screen =
          fresh.WaitFor([&](const std::string& seen) { return names(seen) == names(resized[i]); });
      EXPECT_EQ(names(screen), names(resized[i])) << sizes[i].first;
    }
  }
}

TEST_F(SpyTest, TheTerminalIsAsItWasAfterQuittingAndAfterSignals) {
  REQUIRE_TMUX();
  WriteLog();
  const std::string before = folder_ / "before", after = folder_ / "after";
  const auto read = [](const std::string& path) {
    std::ifstream file(path);
    return std::string(std::istreambuf_iterator<char>(file), {});
  };
  for (const std::string end : {"q", "C-c", "TERM"}) {
    const std::string program = "echo $$ > " + folder_ / "pid" + "; exec " + SpyCommand();
    std::ofstream(folder_ / "spy.sh") << program << '\n';
    TmuxTerminal terminal("echo earlier; stty -a > " + before + "; sh " + folder_ / "spy.sh" +
                              "; code=$?; stty -a > " + after + "; (exit $code)",
                          80, 24);
    terminal.WaitFor("HPDM_TOOL");
    if (end == "TERM") {
      std::ifstream pid(folder_ / "pid");
      int number = 0;
      pid >> number;
      ASSERT_GT(number, 0);
      kill(number, SIGTERM);
    } else {
      terminal.Press(end);
    }
    const std::string screen = terminal.WaitFor("RC=");
    EXPECT_NE(screen.find("RC=0"), screen.npos) << end << screen;
    EXPECT_NE(screen.find("earlier"), screen.npos) << "the screen before is back";
    EXPECT_EQ(screen.find("HPDM_TOOL"), screen.npos) << screen;
    EXPECT_EQ(read(before), read(after)) << end;
  }
}

TEST_F(SpyTest, ASignalEndsItWhileALargeLogIsRead) {
  REQUIRE_TMUX();
  std::ofstream(log_).flush();
  std::filesystem::resize_file(log_, 12'000'000'000);  // sparse; its search takes 45 s
  std::ofstream(folder_ / "spy.sh") << "echo $$ > " + folder_ / "pid" + "; exec " + SpyCommand();
  TmuxTerminal terminal("sh " + folder_ / "spy.sh", 80, 24);
  const std::string reading = terminal.WaitFor("reading 12,000 MB");
  EXPECT_NE(reading.find("reading 12,000 MB"), reading.npos) << reading;
  std::ifstream pid(folder_ / "pid");
  int number = 0;
  pid >> number;
  ASSERT_GT(number, 0);
  kill(number, SIGTERM);
  const std::string screen = terminal.WaitFor("RC=");
  EXPECT_NE(screen.find("RC=143"), screen.npos) << screen;
}

TEST_F(SpyTest, AnUnknownTerminalIsRefusedWithARemedy) {
  REQUIRE_TMUX();
  WriteLog();
  const TmuxTerminal terminal("TERM=no-such-terminal " + SpyCommand(), 80, 24);
  const std::string screen = terminal.WaitFor("RC=");
  EXPECT_NE(screen.find("RC=3"), screen.npos) << screen;
  EXPECT_NE(screen.find("--once"), screen.npos) << screen;
}

TEST_F(SpyTest, HostileNamesAndDamageSpoilNoScreen) {
  REQUIRE_TMUX();
  WriteLog();
  {
    SessionLog log(folder_ / "hostile.lcmlog", 0);
    event_t event{};
    event.name = "\x1b[2J\x1b[31mred";
    event.text = std::string(5000, 'x') + "\n\r\t\xff\xfe";
    log.Write("\x1b]0;title\a", 0, EncodeMessage(event, &buffer_));
    log.Write("\xff\xfe\xc3", 0, EncodeMessage(event, &buffer_));
    for (int i = 0; i < 300; ++i) log.Write(std::to_string(i).c_str(), 1000 * i, foreign_);
  }
  TmuxTerminal terminal(kSpyProgram + " spy " + folder_ / "hostile.lcmlog", 80, 24);
  std::string screen = terminal.WaitFor("of further channels");
  EXPECT_NE(screen.find("?]0;title?"), screen.npos) << screen;
  EXPECT_NE(screen.find("46 of further channels"), screen.npos) << screen;
  terminal.Press("Enter");
  screen = terminal.WaitFor("?[2J?[31mred");
  EXPECT_NE(screen.find("?[2J?[31mred"), screen.npos) << screen;

  std::fstream file(log_, std::ios::binary | std::ios::in | std::ios::out);
  std::mt19937 random(7);
  const auto size = static_cast<std::uint32_t>(std::filesystem::file_size(log_));
  for (int i = 0; i < 50; ++i) {
    file.seekp(random() % size);
    file.put(static_cast<char>(random()));
  }
  file.close();
  const Ended ended = RunSpy(log_ + " --once --json", folder_);
  EXPECT_EQ(ended.code, 0);
  EXPECT_GT(nlohmann::json::parse(ended.output)["damaged_bytes"], 0);
}

TEST_F(SpyTest, ALiveSessionIsWatchedInATerminalAndByAScript) {
  if (!InsideNetworkNamespace()) {
    REQUIRE_TMUX();
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
    EXPECT_EQ(RunInNetworkNamespace(enter, "SpyTest.ALiveSessionIsWatchedInATerminalAndByAScript"),
              0);
    return;
  }
  const Ended nothing = RunSpy("--once --seconds 0.2", folder_);
  EXPECT_EQ(nothing.code, 1);
  EXPECT_NE(nothing.errors.find("hpdm run SCENE --live"), std::string::npos) << nothing.errors;

  TmuxTerminal terminal(kSpyProgram + " spy", 80, 24);
  const std::string empty = terminal.WaitFor("hpdm run SCENE --live");
  EXPECT_NE(empty.find("No messages yet"), empty.npos) << empty;
  std::jthread sender([](std::stop_token stop) {
    lcm::LCM network(kLocalUrl);
    std::vector<std::uint8_t> buffer;
    for (int i = 0; !stop.stop_requested(); ++i) {
      const auto bytes = EncodeMessage(Tool(i), &buffer);
      network.publish(kToolChannel, bytes.data(), static_cast<unsigned int>(bytes.size()));
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  });
  const std::string screen = terminal.WaitFor("HPDM_TOOL");
  EXPECT_EQ(LineOf(screen, kToolChannel)[1], "hpdm.tool_t") << screen;
  terminal.Press("Enter");
  EXPECT_NE(terminal.WaitFor("█").find("tools[0].p_tip[1]"), std::string::npos);

  const Ended ended = RunSpy("--once --json --seconds 1", folder_);
  ASSERT_EQ(ended.code, 0) << ended.errors;
  const auto channel = nlohmann::json::parse(ended.output)["channels"][0];
  EXPECT_EQ(channel["channel"], kToolChannel);
  EXPECT_EQ(channel["lost"], 0);
  EXPECT_GT(channel["messages"], 10);
  EXPECT_EQ(channel["last"]["values"]["tools[0].p_tip[0]"], 0.25);
}

}  // namespace
}  // namespace hpdm
