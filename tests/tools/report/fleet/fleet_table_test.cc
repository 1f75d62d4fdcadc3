#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <array>

#include "engine/base/error.h"
#include "tests/support/fleet_folder.h"
#include "tools/report/fleet/session_table.h"

namespace hpdm {
namespace {

TEST_F(FleetTest, LinesOfClusterJobsMakeTheSameTable) {
  AddSession("a");
  AddSession("b");
  AddLog("c", "");
  Report({.table = table_});
  const std::string lines = folder_ / "lines", others = folder_ / "others";
  const fs::path here = fs::current_path();
  fs::current_path(root_);
  const std::string a = LineText(SessionLine("./a/", {.force = 1.0})) + "\n";
  WriteAll(lines, a + "torn {\n" + LineText(SessionLine("b")) + "\n");
  WriteAll(others,
           LineText(SessionLine("a")) + "\n" + LineText(SessionLine("./c")) + "\n[1]\n{}\n");
  fs::current_path(here);
  const std::string collected = folder_ / "collected.sqlite";
  testing::internal::CaptureStderr();
  const FleetSummary summary = CollectLines({lines, others}, collected);
  EXPECT_NE(testing::internal::GetCapturedStderr().find("lines:2: not a line"), std::string::npos);
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

TEST_F(FleetTest, TheLineOfTheNewestLogStaysWhateverTheOrder) {
  AddSession("a");
  Json old_line = SessionLine(root_ / "a");
  old_line["session"] = "a";
  Json new_line = old_line, failed = old_line;
  new_line["log_mtime_ns"] = old_line["log_mtime_ns"].get<std::int64_t>() + 1;
  new_line["report"]["scene"] = "new";
  failed.erase("report");
  failed["exit_code"] = nullptr;
  failed["error"] = "ended by a signal";
  const std::vector<std::vector<Json>> orders = {
      {old_line, new_line, failed}, {new_line, failed, old_line}, {failed, old_line, new_line}};
  for (std::size_t i = 0; i < orders.size(); ++i) {
    for (const std::string end : {".sqlite", ".jsonl"}) {
      const std::string table = folder_ / (std::to_string(i) + end);
      for (const Json& line : orders[i]) {
        WriteAll(folder_ / "lines", LineText(line) + "\n");
        CollectLines({folder_ / "lines"}, table);
      }
      const KnownSession kept = OpenSessionTable(table)->Known().at("a");
      EXPECT_EQ(kept.stamp->log_mtime_ns, new_line["log_mtime_ns"]) << table;
      EXPECT_EQ(kept.exit_code, 0) << table;
    }
  }
}

TEST_F(FleetTest, LinesMayComeThroughAPipe) {
  AddSession("a");
  const std::string lines = LineText(SessionLine(root_ / "a")) + "\n";
  std::array<int, 2> ends;
  ASSERT_EQ(pipe(ends.data()), 0);
  ASSERT_LT(lines.size(), 65536u) << "what a pipe holds";
  ASSERT_EQ(write(ends[1], lines.data(), lines.size()), static_cast<ssize_t>(lines.size()));
  close(ends[1]);
  EXPECT_EQ(CollectLines({"/dev/fd/" + std::to_string(ends[0])}, table_).reported, 1u);
  close(ends[0]);
  EXPECT_THROW(CollectLines({root_}, table_), InputError);
}

TEST_F(FleetTest, LinesThatADiskCutShortAreTakenBack) {
  AddSession("a");
  const Json line = SessionLine(root_ / "a");
  const std::string path = folder_ / "table.jsonl";
  const auto table = OpenSessionTable(path);
  table->Add({&line, 1});
  const std::string before = ReadFile(path);
  // A limit of the file's size cuts a write short as a full disk does.
  rlimit limit;
  getrlimit(RLIMIT_FSIZE, &limit);
  const rlimit small = {before.size() + 100, limit.rlim_max};
  const auto handler = signal(SIGXFSZ, SIG_IGN);
  setrlimit(RLIMIT_FSIZE, &small);
  EXPECT_THROW(table->Add({&line, 1}), InputError);
  setrlimit(RLIMIT_FSIZE, &limit);
  signal(SIGXFSZ, handler);
  EXPECT_EQ(ReadFile(path), before);
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

TEST_F(FleetTest, AFileThatIsNotATableStaysAsItIs) {
  AddSession("a");
  const std::string text(5000, 'x');
  WriteAll(folder_ / "notes.sqlite", text);
  EXPECT_THROW(Report({.table = folder_ / "notes.sqlite"}), InputError);
  EXPECT_EQ(ReadFile(folder_ / "notes.sqlite"), text);
  for (const std::string& other : {text, std::string("{\"session\":1}\n"), std::string("# x")}) {
    WriteAll(folder_ / "notes.jsonl", other);
    EXPECT_THROW(Report({.table = folder_ / "notes.jsonl"}), InputError);
    EXPECT_EQ(ReadFile(folder_ / "notes.jsonl"), other);
  }
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

}  // namespace
}  // namespace hpdm
