// hpdm report on real logs, sound and damaged.

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "engine/base/error.h"
#include "tests/support/recorded_report.h"
#include "tools/report/metrics/metric_definitions.h"
#include "tools/report/metrics/report_json.h"
#include "tools/report/page/report_page.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

std::string ShownAt(const std::string& page, const std::string& key) {
  const std::string cell = "data-key=\"" + key + "\">";
  const std::size_t at = page.find(cell);
  if (at == std::string::npos) return "";
  const std::size_t begin = at + cell.size();
  return page.substr(begin, page.find('<', begin) - begin);
}

TEST_F(ReportTest, WritesItsPageBesideTheLog) {
  const fs::path folder = folder_ / "session";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  const Outcome report = Hpdm("report " + folder.string());
  EXPECT_EQ(report.exit_code, 0) << report.err;
  EXPECT_EQ(report.out, (folder / "report.html").string() + "\n");
  EXPECT_EQ(report.err, "");
  EXPECT_GT(fs::file_size(folder / "report.html"), 100'000u);
}

TEST_F(ReportTest, NamesAFileThatHasChangedSinceTheSession) {
  const fs::path folder = folder_ / "session";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  std::string mesh;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".obj") mesh = entry.path();
  }
  ASSERT_NE(mesh, "");
  std::ofstream(mesh, std::ios::app) << "# more\n";
  const Outcome report = Hpdm("report " + folder.string());
  EXPECT_EQ(report.exit_code, 0);
  EXPECT_NE(report.err.find(fs::path(mesh).filename().string() +
                            " differs from the file that the session read"),
            std::string::npos)
      << report.err;
  EXPECT_EQ(std::count(report.err.begin(), report.err.end(), '\n'), 1) << report.err;
}

TEST_F(ReportTest, ItsOwnPageNeverLeadsOutOfTheFolder) {
  const fs::path folder = folder_ / "session", page = folder / "report.html";
  fs::create_directory(folder);
  fs::copy_file(Recorded() + "/session.lcmlog", folder / "session.lcmlog");
  std::ofstream(folder_ / "victim.txt") << "precious";
  fs::create_symlink("../victim.txt", page);
  EXPECT_EQ(Hpdm("report " + folder.string()).exit_code, 0);
  EXPECT_EQ(ReadFile(folder_ / "victim.txt"), "precious");
  EXPECT_FALSE(fs::is_symlink(page));
  EXPECT_GT(fs::file_size(page), 100'000u);

  fs::remove(page);
  ASSERT_EQ(mkfifo(page.c_str(), 0600), 0);  // would wait for a reader for ever
  const Outcome refused = Hpdm("report " + folder.string());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("not a file"), std::string::npos) << refused.err;
}

TEST_F(ReportTest, ForcesAreThoseOfTheSessionsSummary) {
  const Json summary = Json::parse(ReadFile(Recorded() + "/summary.json")), results = Results();
  ASSERT_EQ(results["hands"].size(), 2u);
  EXPECT_EQ(results["scene"], summary["scene"]);
  EXPECT_NEAR(results["duration_s"], 6, 1e-9);
  for (std::size_t h = 0; h < 2; ++h) {
    const Json &hand = results["hands"][h], &tool = summary["tools"][h];
    EXPECT_EQ(hand["name"], tool["name"]);
    EXPECT_EQ(hand["peak_force_N"], tool["peak_force_N"]);
    EXPECT_EQ(hand["deepest_press_m"], tool["deepest_press_m"]);
    // Sums of thousands of terms, in another order.
    EXPECT_NEAR(hand["mean_force_N"], tool["mean_force_N"].get<double>(), 1e-9);
    EXPECT_NEAR(hand["contact_time_s"], tool["contact_time_s"].get<double>(), 1e-9);
    EXPECT_GT(hand["path_length_m"], 0.1);
    EXPECT_GT(hand["movements"], 3);
    // These hands reach along minimum-jerk lines.
    EXPECT_NEAR(hand["smoothness_sparc"], -1.4, 0.1);
  }
  EXPECT_EQ(results["log_health"]["sound"], true);
}

TEST_F(ReportTest, NumbersOnThePageAreTheJsons) {
  const std::string page = Page();
  const Json results = Results();
  for (std::size_t h = 0; h < 2; ++h) {
    for (const MetricDefinition& metric : MetricDefinitions()) {
      const std::string shown = ShownAt(page, "hands." + std::to_string(h) + "." + metric.key);
      ASSERT_NE(shown, "") << metric.key;
      const Json& value = results["hands"][h][metric.key];
      if (value.is_null()) continue;
      const auto point = std::string(metric.format).find('.');
      const double half =
          0.5 * std::pow(10, '0' - metric.format[point + 1]);  // in units of the last digit
      EXPECT_NEAR(std::stod(shown), metric.scale * value.get<double>(), half * 1.001) << metric.key;
    }
  }
}

TEST_F(ReportTest, EveryFigureIsDefinedOnThePageAndInTheReadme) {
  const std::string page = Page(), readme = ReadFile(HPDM_SOURCE_DIR "/tools/report/README.md");
  const Json hand = Results()["hands"][0];
  for (const auto& [key, value] : hand.items()) {
    if (key == "name") continue;
    EXPECT_NE(readme.find("`" + key), std::string::npos) << key;
    if (!value.is_number() && !value.is_null()) continue;
    ASSERT_NE(FindMetric(key), nullptr) << key;
    EXPECT_NE(page.find("id=\"def-" + key + "\""), std::string::npos) << key;
  }
  for (const MetricDefinition& metric : MetricDefinitions()) {
    const std::string cited = metric.source;
    for (std::size_t at = 0; at < cited.size(); at = cited.find("; ", at) + 2) {
      const std::string key = cited.substr(at, cited.find("; ", at) - at);
      EXPECT_TRUE(std::any_of(MetricSources().begin(), MetricSources().end(),
                              [&](const MetricSource& source) { return source.key == key; }))
          << key;
      if (cited.find("; ", at) == std::string::npos) break;
    }
  }
}

TEST_F(ReportTest, TheForceLimitIsAnOption) {
  const Json strict = Results("--force-limit 0.5"), lax = Results("--force-limit 9");
  EXPECT_GT(strict["hands"][1]["over_limit_s"], 0);
  EXPECT_GT(strict["hands"][1]["over_limit_count"], 0);
  EXPECT_EQ(lax["hands"][1]["over_limit_s"], 0);
  EXPECT_NE(Page("--force-limit 0.5").find("above the force limit of 0.5 N"), std::string::npos);
  EXPECT_EQ(Hpdm("report " + Recorded() + " --force-limit 0").exit_code, 2);
}

TEST_F(ReportTest, ComparesWithAnotherSession) {
  const std::string page = Page("--against " + Recorded());
  EXPECT_NE(page.find("Compared with: <b>session</b>, two hands on a liver"), std::string::npos);
  EXPECT_NE(page.find("<td class=\"number difference\">0.0\u00a0s</td>"), std::string::npos);
  EXPECT_EQ(page.find(">better<"), std::string::npos) << "with itself nothing has changed";
  EXPECT_EQ(page.find("not-the-same-task"), std::string::npos);
  const Json results = Results("--against " + Recorded());
  EXPECT_EQ(results["against"]["hands"], results["hands"]);
  EXPECT_EQ(results["comparison"]["hands"][1]["differences"]["idle_s"]["verdict"], "same");
}

TEST_F(ReportTest, ASessionOfAnotherTaskIsComparedWithAWarningAndWithoutAJudgement) {
  const std::string other = folder_ / "other";
  const Outcome run = Hpdm("run " HPDM_SOURCE_DIR
                           "/scenes/liver_palpation.toml --clock lockstep --seconds 2 "
                           "--no-pictures --out " +
                           other);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Outcome report = Hpdm("report " + Recorded() + " --against " + other + " --out " + page_);
  EXPECT_EQ(report.exit_code, 0);
  for (const char* difference : {"another scene", "other instruments", "another length"}) {
    EXPECT_NE(report.err.find(difference), std::string::npos) << report.err;
    EXPECT_NE(ReadFile(page_).find(std::string("<li class=\"bad\">") + difference),
              std::string::npos);
  }
  const std::string page = ReadFile(page_);
  EXPECT_NE(page.find("no difference is called better or worse"), std::string::npos);
  EXPECT_EQ(page.find(">better<"), std::string::npos);
  EXPECT_EQ(page.find(">worse<"), std::string::npos);
}

TEST_F(ReportTest, ShowsTheUsersScreenshotsWithTheirPlaceInTheFolder) {
  const fs::path folder = folder_ / "session";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  fs::create_directory(folder / "screenshots");
  const auto picture = [&folder](const std::string& name, std::size_t bytes) {
    std::ofstream(folder / name, std::ios::binary) << "\x89PNG\r\n\x1a\n"
                                                   << std::string(bytes, 'x');
  };
  picture("deepest.png", 10);
  picture("screenshots/screenshot_0001.png", 4'000'000);
  picture("screenshots/screenshot_0002.png", 4'000'000);
  picture("screenshots/screenshot_0003.png", 10);
  SessionFiles files = FindSessionFiles(folder);
  LoadPictures(&files);
  ASSERT_EQ(files.pictures.size(), 3u);
  EXPECT_EQ(files.pictures[0].name, "deepest.png");
  EXPECT_EQ(files.pictures[1].name, "screenshots/screenshot_0001.png");
  EXPECT_EQ(files.pictures[2].name, "screenshots/screenshot_0003.png");
  EXPECT_EQ(files.screenshots_left_out, 1u);

  SessionReading reading = ReadSession(files, kDefaultForceLimit);
  reading.report.events.push_back(
      {12.3, EventSeverity::kInfo, "render.screenshot", "screenshot_0003.png"});
  const std::string page = ReportPageText(reading, files);
  EXPECT_NE(page.find("<figcaption>Screenshot 3, at 12.3 s<"), std::string::npos);
  EXPECT_NE(page.find("1 of the screenshots, which would make this page too large"),
            std::string::npos);
}

TEST_F(ReportTest, LatenciesAreFolded) {
  const std::string page = Page();
  const std::size_t panel = page.find("id=\"latency\"");
  EXPECT_LT(page.find("<details><summary>6,000 haptic ticks ran, 0 were skipped", panel),
            page.find("id=\"events\""));
}

TEST_F(ReportTest, BadInputIsOneLineAndExitTwo) {
  std::ofstream(folder_ / "empty.lcmlog");
  std::ofstream(folder_ / "text.lcmlog") << "no log at all\n";
  for (const std::string& arguments :
       {folder_ / "missing", folder_ / "empty.lcmlog", folder_ / "text.lcmlog",
        folder_.path().string(), Recorded() + " --out " + folder_ / "absent/report.html",
        Recorded() + " --out " + folder_.path().string(),
        Recorded() + " --against " + folder_ / "missing"}) {
    const Outcome report = Hpdm("report " + arguments);
    EXPECT_EQ(report.exit_code, 2) << arguments;
    EXPECT_EQ(std::count(report.err.begin(), report.err.end(), '\n'), 1) << report.err;
    EXPECT_EQ(report.out, "") << arguments;
  }
}

TEST_F(ReportTest, TheLogIsNeverOverwritten) {
  const std::string log = folder_ / "session.lcmlog";
  fs::copy_file(Recorded() + "/session.lcmlog", log);
  fs::create_symlink(log, page_);
  for (const std::string& out : {log, page_}) {
    EXPECT_EQ(Hpdm("report " + log + " --out " + out).exit_code, 2);
  }
  EXPECT_EQ(ReadFile(log), ReadFile(Recorded() + "/session.lcmlog"));
}

TEST_F(ReportTest, AReadOnlyFolderAsksForAnotherFile) {
  const fs::path folder = folder_ / "session";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  fs::permissions(folder, fs::perms::owner_read | fs::perms::owner_exec);
  if (access(folder.c_str(), W_OK) == 0) {
    fs::permissions(folder, fs::perms::owner_all);
    GTEST_SKIP() << "this user may write everywhere";
  }
  const Outcome report = Hpdm("report " + folder.string());
  EXPECT_EQ(report.exit_code, 2);
  EXPECT_NE(report.err.find("cannot be written"), std::string::npos);
  EXPECT_EQ(Hpdm("report " + folder.string() + " --out " + page_).exit_code, 0);
  fs::permissions(folder, fs::perms::owner_all);
}

TEST_F(ReportTest, ATornLogIsReportedWithItsDamage) {
  const fs::path log = folder_ / "torn.lcmlog";
  fs::copy_file(Recorded() + "/session.lcmlog", log);
  fs::resize_file(log, fs::file_size(log) / 2 + 7);
  const Outcome report = Hpdm("report " + log.string() + " --out " + page_);
  EXPECT_EQ(report.exit_code, 0);
  EXPECT_NE(report.err.find("not closed"), std::string::npos);
  const std::string page = ReadFile(page_);
  EXPECT_NE(page.find("are an incomplete event"), std::string::npos);
  EXPECT_NE(page.find("which are in a session"), std::string::npos);
}

TEST_F(ReportTest, NoPrefixAndNoFlippedByteCrashesIt) {
  const std::string bytes = ReadFile(Recorded() + "/session.lcmlog").substr(0, 600'000);
  const std::string log = folder_ / "damaged.lcmlog";
  std::mt19937 random(11);
  const auto report = [&](const std::string& damaged) {
    std::ofstream(log, std::ios::binary) << damaged;
    try {
      const SessionReading reading = ReadSession(log);
      const SessionFiles files = FindSessionFiles(log);
      EXPECT_LT(ReportPageText(reading, files).size(), 5'000'000u);
      EXPECT_FALSE(reading.report.health.Sound());  // all lack the end
      EXPECT_TRUE(std::isfinite(reading.report.duration));
    } catch (const InputError& error) {
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  };
  for (int i = 0; i < 30; ++i) report(bytes.substr(0, random() % bytes.size()));
  for (int i = 0; i < 30; ++i) {
    std::string damaged = bytes;
    for (int k = 0; k < 200; ++k) damaged[random() % damaged.size()] ^= static_cast<char>(random());
    report(damaged);
  }
}

TEST_F(ReportTest, InstrumentsHaveTheNamesOfTheSceneBesideTheLog) {
  const std::vector<std::vector<std::string>> names = FindSessionFiles(Recorded()).instruments;
  ASSERT_EQ(names.size(), 2u);
  EXPECT_EQ(names[0].front(), Results()["hands"][0]["name"]);
  EXPECT_EQ(names[0][1], "hook") << "the first exchange of scenes/two_hands.toml";
  EXPECT_EQ(FindSessionFiles(Recorded() + "/session.lcmlog").instruments, names);
}

TEST_F(ReportTest, NothingOutsideOfTheFolderIsRead) {
  const fs::path folder = folder_ / "session", secret = folder_ / "secret.png";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  std::ofstream(secret, std::ios::binary) << "\x89PNG\r\n\x1a\nsecret";
  std::ofstream(folder / "last.png", std::ios::binary) << "\x89PNG\r\n\x1a\nshown";
  std::ofstream(folder / "summary.json") << "{\"scene\": 7}";
  fs::create_symlink(secret, folder / "deepest.png");
  fs::create_directory_symlink(folder_.path(), folder / "frames");
  fs::rename(folder / "scene.toml", folder_ / "elsewhere.toml");
  fs::create_symlink("../elsewhere.toml", folder / "scene.toml");
  SessionFiles files = FindSessionFiles(folder);
  LoadPictures(&files);
  EXPECT_TRUE(files.instruments.empty());
  ASSERT_EQ(files.pictures.size(), 1u);
  EXPECT_EQ(files.pictures[0].name, "last.png");
  EXPECT_EQ(files.scene, "");
}

}  // namespace
}  // namespace hpdm
