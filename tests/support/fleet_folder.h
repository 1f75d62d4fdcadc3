#pragma once

#include <gtest/gtest.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/liver_scene.h"
#include "tests/support/made_session.h"
#include "tests/support/program.h"
#include "tests/support/recorded_session.h"
#include "tests/support/scratch_folder.h"
#include "tools/report/fleet/fleet.h"
#include "tools/report/fleet/session_line.h"
#include "tools/session/session_path.h"

namespace hpdm {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

inline const std::string kScripts = std::string(HPDM_SOURCE_DIR) + "/tools/report/";

inline void WriteAll(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

/// A short session of two hands on a liver, recorded once.
inline const std::string& SessionBytes() {
  static const std::string bytes = [] {
    const ScratchFolder folder;
    WriteAll(folder / "scene.toml",
             kMetricLiver + kRearSupport +
                 "[[instrument]]\nname = \"left\"\ntrocar = [0.05, -0.12, 0.16]\n"
                 "  [instrument.hand]\n  script = \"palpate\"\n  speed = 0.3\n"
                 "[[instrument]]\nname = \"right\"\ntrocar = [-0.06, -0.12, 0.15]\n"
                 "  [instrument.hand]\n  script = \"palpate\"\n  speed = 0.3\n");
    Record({.scene = folder / "scene.toml",
            .log = folder / "session.lcmlog",
            .ticks = 300,
            .hand_lead_ms = 500});
    return ReadFile(folder / "session.lcmlog");
  }();
  return bytes;
}

/// Names that a shell, SQL, JSON or a terminal could take for something else.
inline const std::vector<std::string> kHostileNames = {"a b",
                                                       "it's",
                                                       "say \"x\"",
                                                       "new\nline",
                                                       "\xFF\xFE",
                                                       "-rf",
                                                       "$(touch pwned)",
                                                       "*",
                                                       "`id`; x",
                                                       "'; DROP TABLE sessions; --",
                                                       "back\\slash",
                                                       "\xC3\xA9t\xC3\xA9",
                                                       "esc\x1B[2J",
                                                       "%s%n",
                                                       "{}",
                                                       "[1,2]"};

class FleetTest : public testing::Test {
 protected:
  void AddSession(const std::string& name) {
    WriteAll(root_ / name / kSessionLogName, SessionBytes());
  }
  void AddLog(const std::string& name, const std::string& bytes) {
    WriteAll(root_ / name / kSessionLogName, bytes);
  }
  /// Writes about 30 sound and faulty sessions; returns the names of those without a report.
  std::set<std::string> AddMany() {
    for (const std::string& name : kHostileNames) AddSession(name);
    for (const char* name : {"2026/01/a", "2026/01/b", "2026/02/deep/er/c"}) AddSession(name);
    const std::string& sound = SessionBytes();
    std::mt19937 random(5);
    for (int i = 0; i < 4; ++i) {
      std::string damaged = sound;
      for (int k = 0; k < 20; ++k) damaged[random() % damaged.size()] ^= 0x10;
      AddLog("damaged " + std::to_string(i), damaged);
      AddLog("torn " + std::to_string(i), sound.substr(0, sound.size() / 5 * (i + 1)));
    }
    MadeSession attached;
    attached.Press(300, 2, 0);
    attached.Step({{}, {.load_W = {0, 3, 4}, .largest_damage = 1, .freed_area = 2e-4}});
    attached.Finish();
    AddLog("attached", ReadFile(attached.log()));
    AddLog("empty", "");
    AddLog("garbage", std::string(100'000, 'x'));
    fs::create_directories(root_ / "folder" / kSessionLogName);
    fs::create_directories(root_ / "dangling");
    fs::create_symlink("nowhere", root_ / "dangling" / kSessionLogName);
    std::set<std::string> unusable = {"empty", "garbage", "folder", "dangling"};
    if (geteuid() != 0) {
      AddSession("unreadable");
      fs::permissions(root_ / "unreadable" / kSessionLogName, fs::perms::none);
      unusable.insert("unreadable");
    }
    // Adds files that are not sessions, and links to places inside and outside the folder.
    fs::create_directories(root_ / "inside");
    fs::create_symlink(root_ / "a b" / kSessionLogName, root_ / "inside" / kSessionLogName);
    WriteAll(root_ / "notes.txt", "session.lcmlog");
    WriteAll(folder_.path() / "elsewhere" / kSessionLogName, sound);
    fs::create_directory_symlink(folder_.path() / "elsewhere", root_ / "linked");
    fs::create_directories(root_ / "outside");
    fs::create_symlink(folder_.path() / "elsewhere" / kSessionLogName,
                       root_ / "outside" / kSessionLogName);
    return unusable;
  }

  struct Outcome {
    FleetSummary summary;
    std::vector<Json> lines;
    std::string err;
  };
  Outcome Report(FleetOptions options) {
    options.folder = root_;
    if (options.program == "/proc/self/exe") options.program = kHpdmProgram;
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    Outcome outcome;
    try {
      outcome.summary = ReportAll(options);
    } catch (...) {
      testing::internal::GetCapturedStdout();
      testing::internal::GetCapturedStderr();
      throw;
    }
    std::istringstream out(testing::internal::GetCapturedStdout());
    for (std::string line; std::getline(out, line);) outcome.lines.push_back(Json::parse(line));
    outcome.err = testing::internal::GetCapturedStderr();
    return outcome;
  }

  /// Rows of a query as objects of column and value.
  static std::vector<Json> Rows(const std::string& table, const std::string& sql) {
    sqlite3* database = nullptr;
    EXPECT_EQ(sqlite3_open_v2(table.c_str(), &database, SQLITE_OPEN_READONLY, nullptr), SQLITE_OK);
    sqlite3_stmt* statement = nullptr;
    EXPECT_EQ(sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr), SQLITE_OK)
        << sqlite3_errmsg(database);
    std::vector<Json> rows;
    while (sqlite3_step(statement) == SQLITE_ROW) {
      Json row = Json::object();
      for (int c = 0; c < sqlite3_column_count(statement); ++c) {
        Json& cell = row[sqlite3_column_name(statement, c)];
        switch (sqlite3_column_type(statement, c)) {
          case SQLITE_INTEGER:
            cell = sqlite3_column_int64(statement, c);
            break;
          case SQLITE_FLOAT:
            cell = sqlite3_column_double(statement, c);
            break;
          case SQLITE_TEXT:
            cell = reinterpret_cast<const char*>(sqlite3_column_text(statement, c));
        }
      }
      rows.push_back(row);
    }
    sqlite3_finalize(statement);
    sqlite3_close(database);
    return rows;
  }
  static std::int64_t Count(const std::string& table, const std::string& of) {
    return Rows(table, "SELECT count(*) AS n FROM " + of)[0]["n"];
  }

  const ScratchFolder folder_;
  const fs::path root_ = folder_.path() / "all";
  const std::string table_ = folder_ / "table.sqlite";
};

}  // namespace hpdm
