#include "tools/report/fleet/fleet_command.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

#include "tests/support/fleet_folder.h"

namespace hpdm {
namespace {

TEST_F(FleetTest, TheCommandPrintsOneLineAndItsExitCodeSaysTheResult) {
  AddSession("a");
  AddLog("b", "");
  const std::string out = folder_ / "out", err = folder_ / "err";
  const auto run = [&](const std::string& words) {
    return Shell(kHpdmProgram + " report " + words + " >" + out + " 2>" + err);
  };
  const auto lines = [](const std::string& text) {
    return std::count(text.begin(), text.end(), '\n');
  };
  const std::string a = (root_ / "a").string(), b = (root_ / "b").string(), all = root_.string();
  EXPECT_EQ(run("--json-line " + a), 0);
  EXPECT_EQ(lines(ReadFile(out)), 1);
  EXPECT_EQ(lines(ReadFile(err)), 0);
  EXPECT_EQ(run("--json-line " + b), 2);
  EXPECT_EQ(lines(ReadFile(out)), 1);
  EXPECT_EQ(lines(ReadFile(err)), 1);
  EXPECT_EQ(run("--all " + all), 1);
  EXPECT_EQ(lines(ReadFile(out)), 2);
  EXPECT_EQ(run("--all " + a), 0);
  EXPECT_EQ(Json::parse(ReadFile(out))["session"], ".");
  EXPECT_EQ(run("--all " + a + " --out " + table_), 0);
  EXPECT_EQ(ReadFile(out), table_ + ": added 1 report\n") << "the table has the line";
  for (const std::string& words :
       {"--all " + all + "/none", std::string("--all"), "--all --json-line " + all, "--jobs 2 " + a,
        "--all --jobs 0 " + all, "--collect " + out, "--all --out /proc/t.sqlite " + all,
        "--collect " + out + " --all " + all}) {
    EXPECT_EQ(run(words), 2) << words;
    EXPECT_EQ(lines(ReadFile(err)), 1) << words << "\n" << ReadFile(err);
  }
  if (access("/dev/full", W_OK) == 0) {
    for (const char* what : {"--all ", "--json-line "}) {
      EXPECT_EQ(Shell(kHpdmProgram + " report " + what + a + " >/dev/full 2>" + err), 2);
      EXPECT_EQ(lines(ReadFile(err)), 1) << ReadFile(err);
    }
  }
}

TEST_F(FleetTest, EveryCommandTakesASessionsFolderOrItsLog) {
  AddSession("a");
  fs::create_directories(root_ / "link");
  fs::create_symlink(root_ / "a" / kSessionLogName, root_ / "link" / kSessionLogName);
  const std::string folder = (root_ / "a").string(), log = folder + "/" + kSessionLogName;
  const std::string out = folder_ / "out", err = folder_ / "err";
  const std::string repaired = folder_ / "repaired.lcmlog";
  for (const std::string& command :
       {"log check --json --repair " + repaired, std::string("spy --once --json"),
        "log export --json --format mcap --out " + (folder_ / "m.mcap"),
        "replay --json --scene " + (folder_ / "none.toml"), std::string("report --json")}) {
    std::map<std::string, std::string> reported;
    for (const std::string& session : {folder, log}) {
      fs::remove(repaired);
      const int code =
          Shell(kHpdmProgram + " " + command + " " + session + " >" + out + " 2>" + err);
      reported[session] = std::to_string(code) + ReadFile(out) + ReadFile(err);
    }
    EXPECT_EQ(reported[folder].substr(0, 200), reported[log].substr(0, 200)) << command;
    EXPECT_EQ(Shell(kHpdmProgram + " " + command + " " + (root_ / "link").string() + " 2>" + err),
              2);
    EXPECT_NE(ReadFile(err).find("is a link out of the session's folder"), std::string::npos)
        << command << "\n"
        << ReadFile(err);
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
  ASSERT_EQ(Shell("HPDM=" + kHpdmProgram + " HOME=" + folder_.path().string() + " " + kScripts +
                  "report_parallel.sh " + root_.string() + " " + table_ + " 2 >/dev/null 2>" + err),
            0)
      << ReadFile(err);
  EXPECT_EQ(Count(table_, "sessions WHERE exit_code = 0"),
            static_cast<std::int64_t>(kHostileNames.size()));
  const Outcome after = Report({.table = table_});
  EXPECT_EQ(after.summary.unchanged, kHostileNames.size()) << "the same names as --all gives";
  EXPECT_EQ(after.lines.size(), 0u);
  EXPECT_FALSE(fs::exists(root_ / "pwned"));
}

TEST_F(FleetTest, TheRecipeEndsWithoutGnuParallel) {
  if (Shell("command -v bash >/dev/null") != 0) GTEST_SKIP() << "bash is not installed";
  AddSession("a");
  const fs::path bin = folder_.path() / "bin";
  WriteAll(bin / "parallel", "#!/bin/sh\n[ \"$1\" = --version ] && echo \"$IS\"\nexit 255\n");
  fs::permissions(bin / "parallel", fs::perms::owner_all);
  const std::string run = "HPDM=" + kHpdmProgram + " PATH=" + bin.string() + ":$PATH " + kScripts +
                          "report_parallel.sh " + root_.string() + " " + table_ + " 2>" +
                          (folder_ / "err");
  EXPECT_EQ(Shell("IS='parallel from moreutils' " + run), 3);
  EXPECT_EQ(Shell("IS='GNU parallel 20221122' " + run), 255) << "it failed itself";
  EXPECT_FALSE(fs::exists(table_));
}

TEST_F(FleetTest, TheTasksOfTheSlurmArrayTakeEachSessionOnce) {
  if (Shell("command -v bash >/dev/null") != 0) GTEST_SKIP() << "bash is not installed";
  const std::string script = kScripts + "report_slurm.sh", lines = folder_ / "lines";
  EXPECT_EQ(Shell("bash -n " + script), 0);
  EXPECT_EQ(Shell("bash -n " + kScripts + "report_parallel.sh"), 0);
  for (const std::string& name : kHostileNames) AddSession(name);
  AddLog("broken", "");
  const auto run = [&](const std::string& task, const std::string& count) {
    return Shell("HPDM=" + kHpdmProgram + " SESSIONS=" + root_.string() + " LINE_FILES=" + lines +
                 " TASKS=3 SLURM_ARRAY_TASK_MIN=" + task + " SLURM_ARRAY_TASK_COUNT=" + count +
                 " SLURM_ARRAY_TASK_ID=" + task + " " + script + " 2>/dev/null");
  };
  for (const char* task : {"0", "1", "2"}) ASSERT_EQ(run(task, "3"), 0);
  const std::string of_task = ReadFile(lines + "/1.jsonl");
  ASSERT_EQ(run("1", "1"), 0);
  EXPECT_EQ(ReadFile(lines + "/1.jsonl"), of_task) << "alone again, it takes the same sessions";
  EXPECT_EQ(run("3", "4"), 2) << "more tasks than were said";
  ASSERT_EQ(Shell(kHpdmProgram + " report --collect " + lines + "/*.jsonl --out " + table_ + " 2>" +
                  (folder_ / "err")),
            0)
      << ReadFile(folder_ / "err");
  std::size_t count = 0;
  for (const char* task : {"0", "1", "2"}) {
    const std::string text = ReadFile(lines + "/" + task + ".jsonl");
    count += static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  }
  EXPECT_EQ(count, kHostileNames.size() + 1);
  EXPECT_EQ(Report({.table = table_}).summary.unchanged, kHostileNames.size());
}

}  // namespace
}  // namespace hpdm
