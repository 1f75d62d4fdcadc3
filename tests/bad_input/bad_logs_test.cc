// Bad session folders and logs, for every command that reads them:
// tests/bad_input/logs.csv. An input's name is its fault and the command.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <random>

#include "lcmtypes/log/log.h"
#include "lcmtypes/wire/codec.h"
#include "tests/bad_input/bad_input.h"
#include "tests/bad_input/sound_scene.h"
#include "tests/support/read_file.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;

/// A session of a tenth of a second in common/session.
void RecordSession(const fs::path& common) {
  WriteBox(common);
  WithFile("s.toml", SoundScene({.mesh = "box.obj"}))(common);
  const BoundedOutcome outcome =
      RunBounded({.words = {"run", "s.toml", "--clock", "lockstep", "--seconds", "0.1",
                            "--no-pictures", "--out", "session"},
                  .folder = common});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
}

std::vector<LogEvent> Events(const fs::path& log) {
  std::vector<LogEvent> events;
  LogReader reader(log.string());
  for (LogEvent event; reader.Next(&event);) events.push_back(event);
  return events;
}

/// The bytes of an event in a log; order and contents may be wrong.
std::string Bytes(const std::vector<LogEvent>& events) {
  std::string bytes;
  const auto put = [&bytes](std::uint64_t value, int size) {
    for (int i = size; i-- > 0;) bytes += static_cast<char>(value >> (8 * i));
  };
  for (std::size_t i = 0; i < events.size(); ++i) {
    put(0xEDA1DA01, 4);
    put(i, 8);
    put(static_cast<std::uint64_t>(events[i].time_us), 8);
    put(events[i].channel.size(), 4);
    put(events[i].data.size(), 4);
    bytes += events[i].channel;
    bytes.append(events[i].data.begin(), events[i].data.end());
  }
  return bytes;
}

class Logs : public BadInputs {
 public:
  using Change = std::function<void(std::vector<LogEvent>*)>;
  using Spoil = std::function<std::string(std::string)>;

  Logs() : BadInputs("logs", RecordSession) {}

  /// Adds a copy of the session's folder, changed by `make`, for each of `commands`.
  void Folder(const std::string& name, const Make& make,
              const std::vector<std::string>& commands = {"replay", "report", "spy", "check",
                                                          "export"}) {
    const Make copy = [from = common() / "session", make](const fs::path& here) {
      fs::copy(from, here / "x", fs::copy_options::recursive);
      make(here / "x");
    };
    const std::map<std::string, std::vector<std::string>> words = {
        {"replay", {"replay", "x"}},
        {"report", {"report", "x", "--out", "page.html"}},
        {"spy", {"spy", "--once", "x"}},
        {"check", {"log", "check", "x"}},
        {"export", {"log", "export", "x", "--out", "tables"}},
        {"mcap", {"log", "export", "x", "--format", "mcap", "--out", "x.mcap"}},
        {"repair", {"log", "check", "x", "--repair", "mended.lcmlog"}},
        {"line", {"report", "x", "--json-line"}},
        {"all", {"report", ".", "--all", "--jobs", "1", "--out", "t.jsonl"}},
        {"run",
         {"run", "x/scene.toml", "--clock", "lockstep", "--seconds", "0.01", "--no-pictures",
          "--verbose", "--out", "o"}}};
    for (const std::string& command : commands) Add(name + ": " + command, words.at(command), copy);
  }
  /// Replaces the sound session's log.
  void Log(const std::string& name, const Spoil& spoil) {
    Folder(name, [spoil](const fs::path& x) {
      const fs::path log = x / "session.lcmlog";
      const std::string bytes = spoil(ReadFile(log));
      std::ofstream(log, std::ios::binary) << bytes;
    });
  }
  void Changed(const std::string& name, const Change& change) {
    Folder(name, [change](const fs::path& x) {
      const fs::path log = x / "session.lcmlog";
      std::vector<LogEvent> events = Events(log);
      change(&events);
      std::ofstream(log, std::ios::binary) << Bytes(events);
    });
  }
};

/// Offset of the data's length from the event's start.
constexpr std::size_t kDataLength = 24;
constexpr std::size_t kChannelLength = 20;

std::size_t EventStart(const std::string& bytes, int number) {
  std::size_t at = 0;
  for (; number > 0; --number) at = bytes.find("\xED\xA1\xDA\x01", at + 1);
  return at;
}

void AddDamage(Logs* logs) {
  logs->Log("sound", [](const std::string& b) { return b; });
  logs->Log("empty", [](const std::string&) { return std::string(); });
  logs->Log("cut in its first header", [](const std::string& b) { return b.substr(0, 20); });
  logs->Log("cut in the middle", [](const std::string& b) { return b.substr(0, b.size() / 2); });
  logs->Log("cut behind its first event",
            [](const std::string& b) { return b.substr(0, EventStart(b, 1)); });
  logs->Log("the second half alone", [](const std::string& b) { return b.substr(b.size() / 2); });
  logs->Log("a megabyte of zeros", [](const std::string&) { return std::string(1 << 20, '\0'); });
  logs->Log("garbage", [](const std::string&) {
    std::mt19937 random(5);
    std::string bytes(1 << 20, '\0');
    for (char& c : bytes) c = static_cast<char>(random());
    return bytes;
  });
  logs->Log("a hole in the middle", [](std::string b) {
    b.replace(b.size() / 2, 3000, std::string(3000, '\0'));
    return b;
  });
  logs->Log("sync words alone", [](const std::string&) {
    std::string bytes;
    for (int i = 0; i < 100'000; ++i) bytes += "\xED\xA1\xDA\x01";
    return bytes;
  });
  logs->Log("a data length of 4 GB", [](std::string b) {
    b.replace(EventStart(b, 5) + kDataLength, 4, "\xff\xff\xff\xff");
    return b;
  });
  logs->Log("a data length of 2 GB", [](std::string b) {
    b.replace(EventStart(b, 5) + kDataLength, 4, "\x7f\xff\xff\xff");
    return b;
  });
  logs->Log("a channel length of 4 GB", [](std::string b) {
    b.replace(EventStart(b, 5) + kChannelLength, 4, "\xff\xff\xff\xff");
    return b;
  });
  logs->Log("a text file", [](const std::string&) { return std::string("[scene]\nname='x'\n"); });
  logs->Log("the log twice", [](const std::string& b) { return b + b; });
}

bool IsTool(const LogEvent& event) { return event.channel == kToolChannel; }

using LogEvents = std::vector<LogEvent>;

void AddOrders(Logs* logs) {
  logs->Changed("backwards", [](LogEvents* e) { std::reverse(e->begin(), e->end()); });
  logs->Changed("shuffled",
                [](LogEvents* e) { std::shuffle(e->begin(), e->end(), std::mt19937(3)); });
  logs->Changed("without ticks", [](LogEvents* e) { std::erase_if(*e, IsTool); });
  logs->Changed("every third tick missing", [](LogEvents* e) {
    int count = 0;
    std::erase_if(*e, [&](const LogEvent& event) { return IsTool(event) && ++count % 3 == 0; });
  });
  logs->Changed("without events of the session", [](LogEvents* e) {
    std::erase_if(*e, [](const LogEvent& event) { return event.channel == kEventChannel; });
  });
  logs->Changed("one time stamp for all", [](LogEvents* e) {
    for (LogEvent& event : *e) event.time_us = 0;
  });
  logs->Changed("time stamps at the ends of time", [](LogEvents* e) {
    for (std::size_t i = 0; i < e->size(); ++i) {
      (*e)[i].time_us = i % 2 == 0 ? std::numeric_limits<std::int64_t>::min()
                                   : std::numeric_limits<std::int64_t>::max();
    }
  });
}

void AddChannels(Logs* logs) {
  logs->Changed("foreign channels between", [](LogEvents* e) {
    for (std::size_t i = 0; i < e->size(); i += 10) {
      e->insert(e->begin() + static_cast<std::ptrdiff_t>(i),
                LogEvent{.time_us = (*e)[i].time_us, .channel = "CAMERA", .data = {1, 2, 3, 4, 5}});
    }
  });
  logs->Changed("foreign channels alone", [](LogEvents* e) {
    for (LogEvent& event : *e) event.channel = "CAMERA", event.data.assign(20, 7);
  });
  logs->Changed("10,000 channels", [](LogEvents* e) {
    for (int i = 0; i < 10'000; ++i) {
      e->push_back({.time_us = 0, .channel = std::to_string(i), .data = {0}});
    }
  });
  logs->Changed("channels named by a path", [](LogEvents* e) {
    for (LogEvent& event : *e) event.channel.insert(0, "../../");
  });
  logs->Changed("channels named by a terminal's escape", [](LogEvents* e) {
    for (LogEvent& event : *e) event.channel.insert(0, "\x1b[2J\n");
  });
}

void AddMessages(Logs* logs) {
  logs->Changed("messages without data", [](LogEvents* e) {
    for (LogEvent& event : *e) event.data.clear();
  });
  // A type that changed has another hash, the first eight bytes of a message.
  logs->Changed("of another version", [](LogEvents* e) {
    for (LogEvent& event : *e) event.data[0] = static_cast<std::uint8_t>(event.data[0] ^ 0x55);
  });
  logs->Changed("ticks of another version", [](LogEvents* e) {
    for (LogEvent& event : *e) {
      if (IsTool(event)) event.data[0] = static_cast<std::uint8_t>(event.data[0] ^ 0x55);
    }
  });
  logs->Changed("ticks cut short", [](LogEvents* e) {
    for (LogEvent& event : *e) {
      if (IsTool(event)) event.data.resize(event.data.size() - 9);
    }
  });
  logs->Changed("NaN in every tick", [](LogEvents* e) {
    for (LogEvent& event : *e) {
      tool_t message;
      if (!IsTool(event) || !DecodeMessage(event.data, &message)) continue;
      for (double& joint : message.tools.at(0).joints) joint = std::nan("");
      event.data.resize(static_cast<std::size_t>(message.getEncodedSize()));
      message.encode(event.data.data(), 0, static_cast<int>(event.data.size()));
    }
  });
}

const std::vector<std::string> kAllCommands = {"replay", "report", "spy",   "check",
                                               "export", "mcap",   "repair"};

void AddLogFiles(Logs* logs) {
  const auto log = [](const fs::path& x) { return x / "session.lcmlog"; };
  logs->Folder("nothing wrong", [](const fs::path&) {}, {"mcap", "repair", "line", "all", "run"});
  logs->Folder(
      "no log", [log](const fs::path& x) { fs::remove(log(x)); }, kAllCommands);
  logs->Folder("a log that is a folder", [log](const fs::path& x) {
    fs::remove(log(x));
    fs::create_directory(log(x));
  });
  logs->Folder(
      "a log that is a pipe",
      [log](const fs::path& x) {
        fs::remove(log(x));
        mkfifo(log(x).c_str(), 0600);
      },
      kAllCommands);
  logs->Folder("a log that is a link to itself", [log](const fs::path& x) {
    fs::remove(log(x));
    fs::create_symlink("session.lcmlog", log(x));
  });
  logs->Folder("a log that is a link out", [log](const fs::path& x) {
    fs::rename(log(x), x.parent_path() / "elsewhere.lcmlog");
    fs::create_symlink("../elsewhere.lcmlog", log(x));
  });
}

void AddScenesAndMeshes(Logs* logs) {
  const std::vector<std::string> scenes = {"replay", "run"};
  const auto scene = [](const fs::path& x) { return x / "scene.toml"; };
  logs->Folder("no scene", [scene](const fs::path& x) { fs::remove(scene(x)); }, {"replay"});
  logs->Folder(
      "a scene that is a pipe",
      [scene](const fs::path& x) {
        fs::remove(scene(x));
        mkfifo(scene(x).c_str(), 0600);
      },
      scenes);
  logs->Folder(
      "a scene of garbage",
      [scene](const fs::path& x) { std::ofstream(scene(x)) << std::string(1000, '\x80'); }, scenes);
  logs->Folder("a scene of other organs",
               [scene](const fs::path& x) {
                 std::ofstream(scene(x)) << SoundScene({.name = "kidney", .mesh = "box.obj"});
               },
               {"replay"});
  logs->Folder("a scene that names a file outside",
               [scene](const fs::path& x) {
                 std::ofstream(scene(x)) << SoundScene({.mesh = "../../common/box.obj"});
               },
               {"replay"});
  logs->Folder(
      "no mesh", [](const fs::path& x) { fs::remove(x / "box.obj"); }, scenes);
  logs->Folder("another mesh",
               [](const fs::path& x) { std::ofstream(x / "box.obj", std::ios::app) << "# more\n"; },
               {"replay", "report", "run"});
  logs->Folder(
      "a mesh that is a link out",
      [](const fs::path& x) {
        fs::remove(x / "box.obj");
        fs::create_symlink("../../common/box.obj", x / "box.obj");
      },
      scenes);
}

void AddPictures(Logs* logs) {
  logs->Folder("pictures and a summary of garbage",
               [](const fs::path& x) {
                 for (const char* name : {"deepest.png", "last.png", "summary.json"}) {
                   std::ofstream(x / name) << std::string(1000, '\xee');
                 }
               },
               {"report", "all"});
  logs->Folder("pictures and a summary that are pipes",
               [](const fs::path& x) {
                 for (const char* name : {"deepest.png", "last.png", "summary.json"}) {
                   fs::remove(x / name);
                   mkfifo((x / name).c_str(), 0600);
                 }
               },
               {"report", "all"});
}

TEST(BadInput, LogsHaveTheOutcomesOfTheTable) {
  Logs logs;
  AddDamage(&logs);
  AddOrders(&logs);
  AddChannels(&logs);
  AddMessages(&logs);
  AddLogFiles(&logs);
  AddScenesAndMeshes(&logs);
  AddPictures(&logs);
  logs.Compare();
}

}  // namespace
}  // namespace hpdm
