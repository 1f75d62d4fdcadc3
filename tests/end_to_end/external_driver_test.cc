// A session with the example driver, as a user starts them.

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/flow_fixture.h"
#include "tests/support/network_namespace.h"

namespace hpdm {
namespace {

using Json = nlohmann::json;

/// Returns the lines of the blocks of one language in the driver's chapter.
std::vector<std::string> Listings(const std::string& language) {
  std::ifstream chapter(HPDM_SOURCE_DIR "/haptics/device/README.md");
  std::vector<std::string> listings;
  bool inside = false;
  for (std::string line; std::getline(chapter, line);) {
    if (line == "```" + language) {
      inside = true;
      listings.emplace_back();
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      listings.back() += line + "\n";
    }
  }
  return listings;
}

/// Returns the shell line of the chapter that contains `part`, with `build/driver` elsewhere.
std::string ShellLine(const std::string& part, const std::string& build) {
  for (const std::string& listing : Listings("sh")) {
    std::istringstream lines(listing);
    for (std::string line; std::getline(lines, line);) {
      if (line.find(part) == line.npos) continue;
      for (std::size_t at = 0; (at = line.find("build/driver", at)) != line.npos;) {
        line.replace(at, std::string("build/driver").size(), build);
        at += build.size();
      }
      return line;
    }
  }
  return "";
}

TEST_F(Flow, TheDriversChapterShowsTheFilesThemselves) {
  const std::filesystem::path folder = HPDM_SOURCE_DIR "/tools/driver";
  EXPECT_EQ(Listings("cpp"), std::vector{ReadFile(folder / "example_driver.cc")});
  EXPECT_EQ(Listings("python"), (std::vector{ReadFile(folder / "example_driver.py"),
                                             ReadFile(folder / "read_log.py")}));
}

TEST_F(Flow, TheDriversChapterBuildsTheDriver) {
  const std::string build = Folder("driver");
  std::string commands = "cd " HPDM_SOURCE_DIR " && ";
  for (const char* part : {"mkdir", "lcm-gen --cpp", "g++"}) {
    const std::string line = ShellLine(part, build);
    ASSERT_NE(line, "") << part;
    commands += line + " && ";
  }
  EXPECT_EQ(Shell("(" + commands + "true) >" + Folder("err") + " 2>&1"), 0)
      << ReadFile(folder_ / "err");
  EXPECT_TRUE(std::filesystem::exists(build + "/example_driver"));
}

TEST_F(Flow, TheDriverInPythonMovesTheProbeAndTheReaderFindsItsForce) {
  const std::string enter = NetworkNamespaceCommand();
  if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
  const std::string types = Folder("types"), log = Folder("s") + "/session.lcmlog";
  std::string reading = ShellLine("read_log.py", types);
  const std::size_t demo = reading.find("out/demo/session.lcmlog");
  ASSERT_NE(demo, reading.npos);
  reading.resize(demo);
  reading += log;
  std::ofstream(folder_ / "session.sh")
      << "cd " HPDM_SOURCE_DIR "; export PYTHONDONTWRITEBYTECODE=1\n"
      << "ip link set lo up; ip link set lo multicast on; ip route add 239.255.76.67 dev lo\n"
      << "export LCM_DEFAULT_URL='udpm://239.255.76.67:7668?ttl=0'; mkdir " << types << "\n"
      << ShellLine("lcm-gen --python", types) << "\n"
      << ShellLine("example_driver.py", types) << " & driver=$!\n"
      << kHpdmProgram << " run " << kScene << " --device lcm --seconds 4 --fps 0 --json --out "
      << Folder("s") << "\nended=$?; kill $driver\n"
      << reading << "\nexit $ended\n";
  ASSERT_EQ(
      Shell(enter + " sh " + Folder("session.sh") + " >" + Folder("out") + " 2>" + Folder("err")),
      0)
      << ReadFile(folder_ / "err");
  const Json summary = Json::parse(ReadFile(folder_ / "s" / "summary.json"));
  EXPECT_GT(summary["device_link"]["received"], 500);
  EXPECT_EQ(summary["device_link"]["refused"], 0);

  double peak = 0, deepest = 0;
  LogReader reader(log);
  force_t force;
  tool_t tool;
  for (LogEvent event; reader.Next(&event);) {
    if (event.channel == kForceChannel && DecodeMessage(event.data, &force)) {
      peak = std::max(peak, Eigen::Map<const Vector3d>(force.tools[0].force).norm());
    } else if (event.channel == kToolChannel && DecodeMessage(event.data, &tool)) {
      deepest = std::max(deepest, tool.tools[0].joints[2]);
    }
  }
  EXPECT_GT(deepest, 0.16) << "the driver's hand moves between 0.105 and 0.175 m";
  EXPECT_GT(peak, 0.1) << "it presses the liver";
  char line[64];
  std::snprintf(line, sizeof line, "instrument 0: peak force %.3f N\n", peak);
  EXPECT_NE(ReadFile(folder_ / "out").find(line), std::string::npos) << ReadFile(folder_ / "out");
}

TEST_F(Flow, TheProgramsInPythonRefuseBadInputInOneLine) {
  const std::string types = Folder("types");
  ASSERT_EQ(
      Shell("cd " HPDM_SOURCE_DIR "; mkdir " + types + "; " + ShellLine("lcm-gen --python", types)),
      0);
  const std::string python = "PYTHONDONTWRITEBYTECODE=1 PYTHONPATH=" + types + " ";
  const std::string folder = "timeout 20 python3 " HPDM_SOURCE_DIR "/tools/driver/";
  std::vector<std::string> commands = {
      folder + "read_log.py",
      folder + "read_log.py " + types,
      folder + "read_log.py " + Folder("no"),
      folder + "read_log.py " HPDM_SOURCE_DIR "/README.md",
      "LCM_DEFAULT_URL=garbage:// " + folder + "example_driver.py",
      "LCM_DEFAULT_URL=udpm://10.1.2.3:7667 " + folder + "example_driver.py"};
  for (const char* name : {"read_log.py no.lcmlog", "example_driver.py"}) {
    commands.push_back("PYTHONPATH= " + folder + name);  // without the generated module
  }
  const std::string enter = NetworkNamespaceCommand();  // without a route
  if (!enter.empty()) {
    commands.push_back("LCM_DEFAULT_URL= " + enter + " " + folder + "example_driver.py");
  }
  for (const std::string& command : commands) {
    EXPECT_EQ(Shell(python + command + " 2>" + Folder("err")), 2) << command;
    EXPECT_EQ(Count(ReadFile(folder_ / "err"), "\n"), 1) << ReadFile(folder_ / "err");
  }
}

// The example driver as a user starts it, against the real clock, in a network of its own.
TEST_F(Flow, AnExternalDriverMovesTheProbeAndItsLossIsReported) {
  SKIP_WITHOUT_EGL();
  const std::string enter = NetworkNamespaceCommand();
  if (enter.empty()) GTEST_SKIP() << "network namespaces are refused here";
  std::ofstream(folder_ / "session.sh")
      << "ip link set lo up; ip link set lo multicast on; ip route add 239.255.76.67 dev lo\n"
      << "unset LCM_DEFAULT_URL\n"
      << kHpdmProgram << " run " << kScene << " --device lcm --seconds 4 --fps 0 --json --out "
      << Folder("s") << " & session=$!\n"
      << HPDM_BINARY_DIR "/tools/hpdm_example_driver"
      << " & driver=$!\n"
      // Waits for two seconds of log, at most half a minute.
      << "for i in $(seq 300); do sleep 0.1; [ -n \"$(find " << Folder("s")
      << "/session.lcmlog -size +1000k 2>/dev/null)\" ] && break; done\n"
      << "kill $driver; wait $session\n";
  ASSERT_EQ(std::system((enter + " sh " + Folder("session.sh") + " >" + Folder("out") + " 2>" +
                         Folder("err"))
                            .c_str()),
            0)
      << ReadFile(folder_ / "err");
  const Json summary = Json::parse(ReadFile(folder_ / "s" / "summary.json"));
  const Json& link = summary["device_link"];
  EXPECT_GT(link["received"], 500) << "of a driver of 1 kHz";
  EXPECT_EQ(link["refused"], 0);
  // The link sends the ramp-out's ticks too, at most 15.
  const long linked = link["sent"].get<long>() + link["overflows"].get<long>();
  EXPECT_GT(linked, summary["haptic"]["ticks"].get<long>());
  EXPECT_LE(linked, summary["haptic"]["ticks"].get<long>() + 15);
  std::vector<std::string> events;
  LogReader reader((folder_ / "s" / "session.lcmlog").string());
  event_t message;
  for (LogEvent event; reader.Next(&event);) {
    if (event.channel != kEventChannel || !DecodeMessage(event.data, &message)) continue;
    if (message.name.starts_with("device.")) events.push_back(message.name);
  }
  ASSERT_FALSE(events.empty());
  EXPECT_EQ(events.back(), "device.lost");
  EXPECT_GE(Count(ReadFile(folder_ / "err"),
                  "hpdm: note: probe: device lost: pose held, force fading out\n"),
            1)
      << ReadFile(folder_ / "err");
}

}  // namespace
}  // namespace hpdm
