#include "tools/report/fleet/fleet.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>

#include <algorithm>
#include <array>
#include <map>

#include "tests/support/fleet_folder.h"
#include "tools/report/fleet/session_search.h"
#include "tools/report/fleet/session_table.h"
#include "tools/shared/child_process.h"

namespace hpdm {
namespace {

/// Every key of `reported` is a column with its value; integers and booleans are numbers.
void ExpectRow(const Json& row, const Json& reported, const std::set<std::string>& elsewhere) {
  for (const auto& [key, value] : reported.items()) {
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

TEST_F(FleetTest, EverySessionHasALineAndRowsEqualToItsOwnReport) {
  const std::set<std::string> unusable = AddMany();
  const Outcome outcome = Report({.table = table_, .jobs = 2});
  const std::size_t sessions = outcome.summary.sessions;
  EXPECT_GE(sessions, 30u);
  EXPECT_EQ(outcome.lines.size(), sessions);
  EXPECT_EQ(outcome.summary.failed, unusable.size()) << outcome.err;
  EXPECT_EQ(outcome.summary.reported, sessions - unusable.size());
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'),
            static_cast<std::ptrdiff_t>(unusable.size() + 2))
      << "each failure, and the links that lead out:\n"
      << outcome.err;
  EXPECT_NE(outcome.err.find("inside/session.lcmlog: is a link out of its session folder"),
            std::string::npos);
  EXPECT_EQ(Count(table_, "sessions"), static_cast<std::int64_t>(sessions));
  std::map<std::string, Json> lines;
  for (const Json& line : outcome.lines) lines[line["session"]] = line;

  for (const fs::path& folder : FindSessions(root_).folders) {
    const std::string name = SessionName(folder);
    Json alone = SessionLine(root_ / folder);
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
    ExpectRow(row, report,
              {"hands", "attachments", "latencies", "events", "log_health", "skipped",
               "ticks_per_output", "goals"});
    const Json goals = Rows(table_, "SELECT * FROM goals" + where).at(0);
    for (const char* domain : {"bimanual_dexterity", "tissue_handling"}) {
      EXPECT_EQ(goals[domain], report["goals"][domain]["rating"]) << name;
    }
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
    const auto attachments =
        Rows(table_, "SELECT * FROM attachments" + where + " ORDER BY attachment");
    ASSERT_EQ(attachments.size(), report["attachments"].size());
    for (std::size_t a = 0; a < attachments.size(); ++a) {
      ExpectRow(attachments[a], report["attachments"][a], {});
    }
    const auto latencies = Rows(table_, "SELECT * FROM latencies" + where);
    EXPECT_EQ(latencies.size(), report["latencies"].size());
  }
  EXPECT_EQ(Rows(table_, "SELECT peak_load_N FROM attachments WHERE session = 'attached'").size(),
            2);
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
    WriteAll(root_ / "c" / "summary.json", R"({"scene": "liver.toml"})");
    outcome = Report({.table = table});
    ASSERT_EQ(outcome.lines.size(), 1u) << "the scene has another name";
    EXPECT_EQ(outcome.lines[0]["report"]["scene"], "liver.toml");
    outcome = Report({.table = table, .limits = {.force = 0.5}});
    EXPECT_EQ(outcome.summary.reported, 3u) << "other figures";
    EXPECT_EQ(Report({.table = table, .limits = {.force = 0.5}}).summary.unchanged, 3u);
  }
  EXPECT_EQ(Count(table_, "sessions"), 4);
  EXPECT_EQ(Count(table_, "hands"), 6);
}

TEST_F(FleetTest, AReportOfAnotherVersionIsMadeAgain) {
  AddSession("a");
  AddLog("broken", "");
  const std::string lines = folder_ / "table.jsonl";
  Report({.table = lines});
  std::string text;
  std::ifstream file(lines);
  for (std::string line; std::getline(file, line);) {
    Json older = Json::parse(line);
    older["report_version"] = kReportVersion - 1;
    text += LineText(older) + "\n";
  }
  file.close();
  WriteAll(lines, text);
  CollectLines({lines}, table_);
  for (const std::string& table : {table_, lines}) {
    EXPECT_EQ(Report({.table = table}).lines.size(), 2u);
    EXPECT_EQ(Report({.table = table}).lines.size(), 0u);
  }
}

TEST_F(FleetTest, ALogThatCannotBeOpenedIsTriedAgain) {
  // A folder replaces the log: its size and time stay the same, as when rights are missing.
  fs::create_directories(root_ / "a" / kSessionLogName);
  for (const std::string& table : {table_, folder_ / "table.jsonl"}) {
    for (int run = 0; run < 2; ++run) {
      const Outcome outcome = Report({.table = table});
      ASSERT_EQ(outcome.lines.size(), 1u) << run;
      EXPECT_EQ(outcome.lines[0]["exit_code"], 2);
      EXPECT_EQ(outcome.lines[0]["log_mtime_ns"], nullptr);
    }
  }
}

TEST_F(FleetTest, AnErrorIsReportedTheSameWayAgain) {
  AddLog("back\\slash", "");
  const std::string first = Report({.table = table_}).err;
  const std::string again = Report({.table = table_}).err;
  EXPECT_NE(first.find("back\\\\slash/session.lcmlog: "), std::string::npos) << first;
  EXPECT_EQ(again, first.substr(0, first.size() - 1) + " (unchanged)\n");
}

TEST_F(FleetTest, AKilledRunLeavesAUsableTableAndTheNextContinues) {
  for (int i = 0; i < 16; ++i) AddSession(std::to_string(i) + "th");
  {
    ChildProcess run({kHpdmProgram, "report", "--all", root_, "--jobs", "1", "--out", table_});
    const auto table = OpenSessionTable(table_);
    while (table->Known().size() < 3 && !run.silent()) ChildProcess::Poll({&run}, 1);
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
    const std::vector<std::string> words = {kHpdmProgram, "report", "--all", root_, "--out", table};
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
               kHpdmProgram + " \"$@\";;\nesac\n");
  fs::permissions(program, fs::perms::owner_all);
  Outcome outcome = Report({.table = table_, .jobs = 3, .program = program});
  EXPECT_EQ(outcome.summary.reported, 1u) << outcome.err;
  EXPECT_EQ(outcome.summary.failed, 4u);
  for (const char* reported :
       {"hpdm: crash: its reader was ended by signal 11", "hpdm: mute: no room",
        "hpdm: odd: its reader exited with 0 and no report",
        "hpdm: liar: its reader exited with 0 and no report"}) {
    EXPECT_NE(outcome.err.find(reported), std::string::npos) << reported << "\n" << outcome.err;
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
  // Its child processes end with it: until then the pipe stays open.
  std::array<int, 2> alive;
  ASSERT_EQ(pipe(alive.data()), 0);
  WriteAll(program, "#!/bin/sh\nsleep 20 >/dev/null 2>&1 &\nwait\n");
  fs::permissions(program, fs::perms::owner_all);
  const Outcome outcome = Report({.patience = 0.2, .program = program});
  EXPECT_EQ(outcome.summary.failed, 1u);
  EXPECT_EQ(outcome.err, "hpdm: hang: took longer than 0.2 s; give it more time with --timeout\n");
  EXPECT_EQ(outcome.lines[0]["exit_code"], nullptr);
  close(alive[1]);
  pollfd open{alive[0], POLLIN, 0};
  EXPECT_EQ(poll(&open, 1, 5000), 1) << "killed at once, but by another processor";
  close(alive[0]);
}

}  // namespace
}  // namespace hpdm
