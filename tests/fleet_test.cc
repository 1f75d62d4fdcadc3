#include "tools/report/fleet.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sqlite3.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <random>
#include <set>
#include <sstream>

#include "engine/error.h"
#include "tests/recorded_session.h"
#include "tests/scratch_folder.h"
#include "tools/child_process.h"
#include "tools/report/path_text.h"
#include "tools/report/session_line.h"
#include "tools/report/session_search.h"
#include "tools/report/session_table.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

const std::string kProgram = std::string(HPDM_BINARY_DIR) + "/tools/hpdm";
const std::string kScripts = std::string(HPDM_SOURCE_DIR) + "/tools/report/";

std::string ReadAll(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void WriteAll(const fs::path& path, const std::string& bytes) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
}

/// A short session of two hands on a liver, recorded once.
const std::string& SessionBytes() {
  static const std::string bytes = [] {
    const ScratchFolder folder;
    WriteAll(folder / "scene.toml",
             "[[organ]]\nname = \"liver\"\nmesh = \"" HPDM_SOURCE_DIR
             "/scenes/meshes/liver_274.obj\"\n"
             "  [[organ.support]]\n  box_fraction = { min = [0.0, 0.7, 0.0], max = [1, 1, 1] }\n"
             "  fixed = true\n"
             "[[instrument]]\nname = \"left\"\ntrocar = [0.05, -0.12, 0.16]\n"
             "  [instrument.hand]\n  script = \"palpate\"\n  speed = 0.3\n"
             "[[instrument]]\nname = \"right\"\ntrocar = [-0.06, -0.12, 0.15]\n"
             "  [instrument.hand]\n  script = \"palpate\"\n  speed = 0.3\n");
    Record({.scene = folder / "scene.toml",
            .log = folder / "session.lcmlog",
            .ticks = 300,
            .hand_lead_ms = 500});
    return ReadAll(folder / "session.lcmlog");
  }();
  return bytes;
}

/// Names that a shell, SQL, JSON or a terminal could take for something else.
const std::vector<std::string> kHostileNames = {"a b",
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
  /// Some 30 sessions, sound and not; the names of those that no report can be made of.
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
    // No sessions: other files, and links to what is elsewhere.
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
    if (options.program == "/proc/self/exe") options.program = kProgram;
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

/// Every key of `told` is a column with its value; integers and booleans are numbers.
void ExpectRow(const Json& row, const Json& told, const std::set<std::string>& elsewhere) {
  for (const auto& [key, value] : told.items()) {
    if (elsewhere.contains(key)) continue;
    ASSERT_TRUE(row.contains(key)) << key;
    if (value.is_number()) {
      EXPECT_EQ(row[key].get<double>(), value.get<double>()) << key;
    } else if (value.is_boolean()) {
      EXPECT_EQ(row[key], value.get<bool>() ? 1 : 0) << key;
    } else {
      EXPECT_EQ(row[key], value) << key;
    }
  }
}

TEST_F(FleetTest, EverySessionIsALineAndRowsEqualToItsOwnReport) {
  const std::set<std::string> unusable = AddMany();
  const Outcome outcome = Report({.table = table_, .jobs = 2});
  const std::size_t sessions = outcome.summary.sessions;
  EXPECT_GE(sessions, 30u);
  EXPECT_EQ(outcome.lines.size(), sessions);
  EXPECT_EQ(outcome.summary.failed, unusable.size()) << outcome.err;
  EXPECT_EQ(outcome.summary.reported, sessions - unusable.size());
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'),
            static_cast<std::ptrdiff_t>(unusable.size() + 1))
      << "each failure, and the link that leads out:\n"
      << outcome.err;
  EXPECT_NE(outcome.err.find("leads out of the folder"), std::string::npos);
  EXPECT_EQ(Count(table_, "sessions"), static_cast<std::int64_t>(sessions));
  std::map<std::string, Json> lines;
  for (const Json& line : outcome.lines) lines[line["session"]] = line;

  for (const fs::path& folder : FindSessions(root_).folders) {
    const std::string name = SessionName(folder);
    Json alone = SessionLine(root_ / folder, kDefaultForceLimit);
    alone["session"] = name;
    ASSERT_TRUE(lines.contains(name)) << name;
    EXPECT_EQ(lines[name], alone);
    std::string quoted;
    for (const char c : name) quoted += c == '\'' ? "''" : std::string(1, c);
    const std::string where = " WHERE session = '" + quoted + "'";
    const Json row = Rows(table_, "SELECT * FROM sessions" + where).at(0);
    ExpectRow(row, alone, {"report"});
    if (unusable.contains(name)) {
      EXPECT_EQ(row["exit_code"], 2) << name;
      EXPECT_FALSE(row["error"].get<std::string>().empty());
      continue;
    }
    const Json& report = alone["report"];
    ExpectRow(row, report, {"hands", "latencies", "events", "log_health", "skipped"});
    EXPECT_EQ(row["ticks_skipped"], report["skipped"]["total"]);
    EXPECT_EQ(row["log_sound"], report["log_health"]["sound"].get<bool>() ? 1 : 0);
    EXPECT_EQ(row["torn_bytes"], report["log_health"]["torn_bytes"]);
    const auto hands = Rows(table_, "SELECT * FROM hands" + where + " ORDER BY hand");
    ASSERT_EQ(hands.size(), report["hands"].size());
    const auto contacts = Rows(table_, "SELECT * FROM contacts" + where + " ORDER BY hand, organ");
    std::size_t c = 0;
    for (std::size_t h = 0; h < hands.size(); ++h) {
      ExpectRow(hands[h], report["hands"][h], {"organs"});
      for (const Json& organ : report["hands"][h]["organs"]) {
        ASSERT_LT(c, contacts.size());
        EXPECT_EQ(contacts[c]["hand"], h);
        EXPECT_EQ(contacts[c]["organ_name"], organ["organ"]);
        ExpectRow(contacts[c++], organ, {"organ"});
      }
    }
    EXPECT_EQ(c, contacts.size());
    const auto latencies = Rows(table_, "SELECT * FROM latencies" + where);
    EXPECT_EQ(latencies.size(), report["latencies"].size());
  }
  EXPECT_GT(Rows(table_, "SELECT min(time_s) AS n FROM hands WHERE session = 'a b'")[0]["n"], 0.29)
      << "300 ticks: the figures are of something";
  EXPECT_FALSE(fs::exists("pwned") || fs::exists(root_ / "pwned"));
}

TEST_F(FleetTest, UnchangedLogsAreReadOnce) {
  for (const char* name : {"a", "b", "c"}) AddSession(name);
  AddLog("broken", "");
  for (const std::string& table : {table_, folder_ / "table.jsonl"}) {
    Outcome outcome = Report({.table = table});
    EXPECT_EQ(outcome.summary.reported, 3u);
    EXPECT_EQ(outcome.summary.failed, 1u);
    outcome = Report({.table = table});
    EXPECT_EQ(outcome.lines.size(), 0u);
    EXPECT_EQ(outcome.summary.unchanged, 3u);
    EXPECT_EQ(outcome.summary.failed, 1u) << "it still fails";
    EXPECT_NE(outcome.err.find("hpdm: broken: "), std::string::npos) << outcome.err;

    fs::last_write_time(
        root_ / "b" / kSessionLogName,
        fs::last_write_time(root_ / "b" / kSessionLogName) + std::chrono::seconds(1));
    outcome = Report({.table = table});
    ASSERT_EQ(outcome.lines.size(), 1u);
    EXPECT_EQ(outcome.lines[0]["session"], "b");
    EXPECT_EQ(Report({.table = table, .again = true}).lines.size(), 4u);
    outcome = Report({.table = table, .force_limit = 0.5});
    EXPECT_EQ(outcome.summary.reported, 3u) << "other figures";
    EXPECT_EQ(Report({.table = table, .force_limit = 0.5}).summary.unchanged, 3u);
  }
  EXPECT_EQ(Count(table_, "sessions"), 4);
  EXPECT_EQ(Count(table_, "hands"), 6);
}

TEST_F(FleetTest, AKilledRunLeavesAUsableTableAndTheNextGoesOn) {
  for (int i = 0; i < 16; ++i) AddSession(std::to_string(i) + "th");
  {
    ChildProcess run({kProgram, "report", "--all", root_, "--jobs", "1", "--out", table_});
    while (std::count(run.out().begin(), run.out().end(), '\n') < 3 && !run.silent()) {
      ChildProcess::Poll({&run}, 1000);
    }
    run.Kill();
  }
  EXPECT_EQ(Rows(table_, "PRAGMA integrity_check")[0]["integrity_check"], "ok");
  const std::int64_t done = Count(table_, "sessions");
  EXPECT_GE(done, 3);
  EXPECT_EQ(Count(table_, "hands"), 2 * done) << "whole sessions alone";
  const Outcome rest = Report({.table = table_, .jobs = 2});
  EXPECT_EQ(rest.summary.unchanged, static_cast<std::size_t>(done));
  EXPECT_EQ(rest.summary.reported, static_cast<std::size_t>(16 - done));
  EXPECT_EQ(Count(table_, "sessions"), 16);
}

TEST_F(FleetTest, TwoRunsAtOnceShareATable) {
  for (int i = 0; i < 10; ++i) AddSession(std::to_string(i) + "th");
  for (const std::string& table : {table_, folder_ / "table.jsonl"}) {
    const std::vector<std::string> words = {kProgram, "report", "--all", root_, "--out", table};
    ChildProcess one(words), other(words);
    while (!one.silent() || !other.silent()) ChildProcess::Poll({&one, &other}, 1000);
    EXPECT_EQ(one.err().find("10 sessions: "), 0u) << one.err();
    EXPECT_EQ(other.err().find("10 sessions: "), 0u) << other.err();
    EXPECT_EQ(OpenSessionTable(table)->Known().size(), 10u);
  }
  EXPECT_EQ(Rows(table_, "PRAGMA integrity_check")[0]["integrity_check"], "ok");
  EXPECT_EQ(Count(table_, "hands"), 20);
}

TEST_F(FleetTest, AReaderThatCrashesCostsItsSessionAlone) {
  for (const char* name : {"crash", "mute", "odd", "liar", "good"}) AddSession(name);
  const std::string program = folder_ / "reader";
  WriteAll(program,
           "#!/bin/sh\nfor folder; do :; done\ncase $folder in\n"
           "*/crash) kill -SEGV $$;;\n*/mute) echo 'no room' >&2; exit 3;;\n"
           "*/odd) echo 'a line';;\n*/liar) echo '{\"session\":\"good\",\"exit_code\":2}';;\n"
           "*) exec " +
               kProgram + " \"$@\";;\nesac\n");
  fs::permissions(program, fs::perms::owner_all);
  Outcome outcome = Report({.table = table_, .jobs = 3, .program = program});
  EXPECT_EQ(outcome.summary.reported, 1u) << outcome.err;
  EXPECT_EQ(outcome.summary.failed, 4u);
  for (const char* told :
       {"hpdm: crash: its reader ended by signal 11", "hpdm: mute: no room",
        "hpdm: odd: its reader ended with code 0 and no report", "hpdm: liar: its reader ended"}) {
    EXPECT_NE(outcome.err.find(told), std::string::npos) << told << "\n" << outcome.err;
  }
  EXPECT_EQ(Rows(table_, "SELECT exit_code FROM sessions WHERE session = 'crash'")[0]["exit_code"],
            nullptr);
  // They are tried again, since the machine may have been the cause.
  outcome = Report({.table = table_});
  EXPECT_EQ(outcome.summary.unchanged, 1u);
  EXPECT_EQ(outcome.summary.reported, 4u);
}

TEST_F(FleetTest, AReaderThatHangsIsEndedWhenItsTimeIsOver) {
  AddSession("hang");
  const std::string program = folder_ / "reader";
  WriteAll(program, "#!/bin/sh\nexec sleep 1000\n");
  fs::permissions(program, fs::perms::owner_all);
  const Outcome outcome = Report({.patience = 0.2, .program = program});
  EXPECT_EQ(outcome.summary.failed, 1u);
  EXPECT_EQ(outcome.err, "hpdm: hang: took longer than 0.2 s; give it more with --timeout\n");
  EXPECT_EQ(outcome.lines[0]["exit_code"], nullptr);
}

TEST_F(FleetTest, LinesOfClusterJobsMakeTheSameTable) {
  AddSession("a");
  AddSession("b");
  AddLog("c", "");
  Report({.table = table_});
  const std::string lines = folder_ / "lines", others = folder_ / "others";
  const fs::path here = fs::current_path();
  fs::current_path(root_);
  const std::string a = LineText(SessionLine("./a/", 1.0)) + "\n";
  WriteAll(lines, a + "torn {\n" + LineText(SessionLine("b", kDefaultForceLimit)) + "\n");
  WriteAll(others, LineText(SessionLine("a", kDefaultForceLimit)) + "\n" +
                       LineText(SessionLine("./c", kDefaultForceLimit)) + "\n[1]\n{}\n");
  fs::current_path(here);
  const std::string collected = folder_ / "collected.sqlite";
  testing::internal::CaptureStderr();
  const FleetSummary summary = CollectLines({lines, others}, collected);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("lines:2: is no line"), std::string::npos);
  EXPECT_EQ(summary.failed, 3u);
  for (const std::string table : {"sessions", "hands", "contacts", "latencies"}) {
    std::vector<Json> expected = Rows(table_, "SELECT * FROM " + table + " ORDER BY 1, 2");
    std::vector<Json> found = Rows(collected, "SELECT * FROM " + table + " ORDER BY 1, 2");
    // The error names the folder as it was given.
    for (std::vector<Json>* rows : {&expected, &found}) {
      for (Json& row : *rows) row.erase("error");
    }
    EXPECT_EQ(found, expected) << table;
  }
  EXPECT_EQ(Report({.table = collected}).summary.unchanged, 2u) << "nothing is left to do";
}

TEST_F(FleetTest, ATornLastLineIsEndedAndReadAgain) {
  AddSession("a");
  AddSession("b");
  const std::string table = folder_ / "table.jsonl";
  Report({.table = table});
  fs::resize_file(table, fs::file_size(table) - 20);
  EXPECT_EQ(Report({.table = table}).summary.reported, 1u);
  EXPECT_EQ(OpenSessionTable(table)->Known().size(), 2u);
}

TEST_F(FleetTest, WhatIsNoTableStaysAsItIs) {
  AddSession("a");
  const std::string text(5000, 'x');
  WriteAll(folder_ / "notes.sqlite", text);
  EXPECT_THROW(Report({.table = folder_ / "notes.sqlite"}), InputError);
  EXPECT_EQ(ReadAll(folder_ / "notes.sqlite"), text);
  sqlite3* database = nullptr;
  sqlite3_open((folder_ / "other.sqlite").c_str(), &database);
  sqlite3_exec(database, "CREATE TABLE sessions (x); INSERT INTO sessions VALUES (1)", nullptr,
               nullptr, nullptr);
  sqlite3_close(database);
  EXPECT_THROW(Report({.table = folder_ / "other.sqlite"}), InputError);
  EXPECT_EQ(Count(folder_ / "other.sqlite", "sessions"), 1);
  EXPECT_THROW(Report({.table = folder_ / "no/such/folder/t.sqlite"}), InputError);
  EXPECT_THROW(Report({.table = root_}), InputError);
  if (access("/dev/full", W_OK) == 0) {
    EXPECT_THROW(Report({.table = "/dev/full"}), InputError);
  }
  EXPECT_THROW(CollectLines({folder_ / "missing"}, table_), InputError);
}

int Shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST_F(FleetTest, TheCommandPrintsOneLineAndTellsByItsCode) {
  AddSession("a");
  AddLog("b", "");
  const std::string out = folder_ / "out", err = folder_ / "err";
  const auto run = [&](const std::string& words) {
    return Shell(kProgram + " report " + words + " >" + out + " 2>" + err);
  };
  const auto lines = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  const std::string a = (root_ / "a").string(), b = (root_ / "b").string(), all = root_.string();
  EXPECT_EQ(run("--json-line " + a), 0);
  EXPECT_EQ(lines(ReadAll(out)), 1);
  EXPECT_EQ(lines(ReadAll(err)), 0);
  EXPECT_EQ(run("--json-line " + b), 2);
  EXPECT_EQ(lines(ReadAll(out)), 1);
  EXPECT_EQ(lines(ReadAll(err)), 1);
  EXPECT_EQ(run("--all " + all), 1);
  EXPECT_EQ(lines(ReadAll(out)), 2);
  EXPECT_EQ(run("--all " + a), 0);
  EXPECT_EQ(Json::parse(ReadAll(out))["session"], ".");
  for (const std::string& words :
       {"--all " + all + "/none", std::string("--all"), "--all --json-line " + all, "--jobs 2 " + a,
        "--all --jobs 0 " + all, "--collect " + out, "--all --out /proc/t.sqlite " + all,
        "--collect " + out + " --all " + all}) {
    EXPECT_EQ(run(words), 2) << words;
    EXPECT_EQ(lines(ReadAll(err)), 1) << words << "\n" << ReadAll(err);
  }
  if (access("/dev/full", W_OK) == 0) {
    for (const char* what : {"--all ", "--json-line "}) {
      EXPECT_EQ(Shell(kProgram + " report " + what + a + " >/dev/full 2>" + err), 2);
      EXPECT_EQ(lines(ReadAll(err)), 1) << ReadAll(err);
    }
  }
}

TEST_F(FleetTest, TheRecipeForGnuParallelMakesTheTable) {
  if (Shell("command -v parallel >/dev/null && parallel --version 2>/dev/null | grep -q GNU") !=
      0) {
    GTEST_SKIP() << "GNU parallel (package parallel) is not installed";
  }
  for (const std::string& name : kHostileNames) AddSession(name);
  AddLog("broken", "");
  const std::string err = folder_ / "err";
  ASSERT_EQ(Shell("HPDM=" + kProgram + " HOME=" + folder_.path().string() + " " + kScripts +
                  "report_parallel.sh " + root_.string() + " " + table_ + " 2 >/dev/null 2>" + err),
            0)
      << ReadAll(err);
  EXPECT_EQ(Count(table_, "sessions WHERE exit_code = 0"),
            static_cast<std::int64_t>(kHostileNames.size()));
  const Outcome after = Report({.table = table_});
  EXPECT_EQ(after.summary.unchanged, kHostileNames.size()) << "the same names as --all gives";
  EXPECT_EQ(after.lines.size(), 0u);
  EXPECT_FALSE(fs::exists(root_ / "pwned"));
}

TEST_F(FleetTest, TheTasksOfTheSlurmArrayTakeEachSessionOnce) {
  if (Shell("command -v bash >/dev/null") != 0) GTEST_SKIP() << "bash is not installed";
  const std::string script = kScripts + "report_slurm.sh", lines = folder_ / "lines";
  EXPECT_EQ(Shell("bash -n " + script), 0);
  EXPECT_EQ(Shell("bash -n " + kScripts + "report_parallel.sh"), 0);
  for (const std::string& name : kHostileNames) AddSession(name);
  AddLog("broken", "");
  for (const char* task : {"1", "2", "3"}) {
    ASSERT_EQ(Shell("HPDM=" + kProgram + " SESSIONS=" + root_.string() + " LINE_FILES=" + lines +
                    " SLURM_ARRAY_TASK_MIN=1 SLURM_ARRAY_TASK_COUNT=3 SLURM_ARRAY_TASK_ID=" + task +
                    " " + script + " 2>/dev/null"),
              0);
  }
  ASSERT_EQ(Shell(kProgram + " report --collect " + lines + "/*.jsonl --out " + table_ + " 2>" +
                  (folder_ / "err")),
            0)
      << ReadAll(folder_ / "err");
  std::size_t count = 0;
  for (const char* task : {"1", "2", "3"}) {
    const std::string text = ReadAll(lines + "/" + task + ".jsonl");
    count += static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  EXPECT_EQ(count, kHostileNames.size() + 1);
  EXPECT_EQ(Report({.table = table_}).summary.unchanged, kHostileNames.size());
}

TEST(PathText, EveryByteComesBackFromOneLineOfUtf8) {
  EXPECT_EQ(PathText("a b/\xC3\xA9"), "a b/\xC3\xA9");
  EXPECT_EQ(PathText("a\nb\x7F"), "a\\x0Ab\\x7F");
  EXPECT_EQ(PathText("a\\x0A"), "a\\\\x0A");
  EXPECT_EQ(PathText("\xC2\x85"), "\\xC2\\x85") << "a control character too";
  // Overlong, a surrogate, too large, torn.
  EXPECT_EQ(PathText("\xC0\x80\xED\xA0\x80\xF4\x90\x80\x80\xE2\x82"),
            "\\xC0\\x80\\xED\\xA0\\x80\\xF4\\x90\\x80\\x80\\xE2\\x82");
  std::mt19937 random(6);
  for (int trial = 0; trial < 2000; ++trial) {
    std::string bytes(random() % 12, '\0');
    for (char& c : bytes) c = static_cast<char>(random() % 4 == 0 ? '\\' : random());
    const std::string text = PathText(bytes);
    EXPECT_NO_THROW(Json(text).dump()) << "it is UTF-8";
    std::string back;
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '\\') {
        back += text[i];
      } else if (text[++i] == '\\') {
        back += '\\';
      } else {
        back += static_cast<char>(std::stoi(text.substr(i + 1, 2), nullptr, 16));
        i += 2;
      }
    }
    EXPECT_EQ(back, bytes);
  }
}

}  // namespace
}  // namespace hpdm
