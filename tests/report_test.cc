// hpdm report on real logs, sound, damaged and hostile; its page in a real browser.

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "engine/error.h"
#include "lcmtypes/telemetry_loop.h"
#include "tests/browser.h"
#include "tests/scratch_folder.h"
#include "tools/report/metric_definitions.h"
#include "tools/report/page_data.h"
#include "tools/report/report_json.h"
#include "tools/report/report_page.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

const std::string kProgram = HPDM_BINARY_DIR "/tools/hpdm";

std::string TextOf(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

struct Outcome {
  int exit_code = -1;
  std::string out, err;
};

/// A session of two simulated hands, recorded once for all tests.
class ReportTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    recorded_ = new ScratchFolder;
    const Outcome run = Hpdm("run " HPDM_SOURCE_DIR
                             "/scenes/two_hands.toml --clock lockstep "
                             "--seconds 6 --no-pictures --out " +
                             Recorded());
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void TearDownTestSuite() {
    delete recorded_;
    recorded_ = nullptr;
  }
  static std::string Recorded() { return *recorded_ / "session"; }

  static Outcome Hpdm(const std::string& arguments) {
    const ScratchFolder folder;
    const std::string out = folder / "out", err = folder / "err";
    const int status = std::system(
        (kProgram + " " + arguments + " >" + out + " 2>" + err + " </dev/null").c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, TextOf(out), TextOf(err)};
  }
  /// A page of the recorded session, and its figures.
  std::string Page(const std::string& options = "") {
    const Outcome report = Hpdm("report " + Recorded() + " --out " + page_ + " " + options);
    EXPECT_EQ(report.exit_code, 0) << report.err;
    return TextOf(page_);
  }
  static Json Figures(const std::string& options = "") {
    return Json::parse(Hpdm("report " + Recorded() + " --json " + options).out);
  }

  inline static ScratchFolder* recorded_ = nullptr;
  ScratchFolder folder_;
  std::string page_ = folder_ / "report.html";
};

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

TEST_F(ReportTest, ForcesAreThoseOfTheSessionsSummary) {
  const Json summary = Json::parse(TextOf(Recorded() + "/summary.json")), figures = Figures();
  ASSERT_EQ(figures["hands"].size(), 2u);
  EXPECT_EQ(figures["scene"], summary["scene"]);
  EXPECT_NEAR(figures["duration_s"], 6, 1e-9);
  for (std::size_t h = 0; h < 2; ++h) {
    const Json &hand = figures["hands"][h], &tool = summary["tools"][h];
    EXPECT_EQ(hand["name"], tool["name"]);
    EXPECT_EQ(hand["peak_force_N"], tool["peak_force_N"]);
    EXPECT_EQ(hand["deepest_press_m"], tool["deepest_press_m"]);
    // Sums of thousands of terms, in another order.
    EXPECT_NEAR(hand["mean_force_N"], tool["mean_force_N"].get<double>(), 1e-9);
    EXPECT_NEAR(hand["contact_time_s"], tool["contact_time_s"].get<double>(), 1e-9);
    EXPECT_GT(hand["path_length_m"], 0.1);
    EXPECT_GT(hand["movements"], 3);
    // These hands reach along minimum-jerk lines.
    EXPECT_NEAR(hand["smoothness_sparc"], -1.4, 0.15);
  }
  EXPECT_EQ(figures["log_health"]["sound"], true);
}

TEST_F(ReportTest, NumbersOnThePageAreTheJsons) {
  const std::string page = Page();
  const Json figures = Figures();
  for (std::size_t h = 0; h < 2; ++h) {
    for (const MetricDefinition& metric : MetricDefinitions()) {
      const std::string shown = ShownAt(page, "hands." + std::to_string(h) + "." + metric.key);
      ASSERT_NE(shown, "") << metric.key;
      const Json& value = figures["hands"][h][metric.key];
      if (value.is_null()) continue;
      const auto point = std::string(metric.format).find('.');
      const double half = 0.5 * std::pow(10, '0' - metric.format[point + 1]);  // of the last digit
      EXPECT_NEAR(std::stod(shown), metric.scale * value.get<double>(), half * 1.001) << metric.key;
    }
  }
}

TEST_F(ReportTest, EveryFigureIsDefinedOnThePageAndInTheReadme) {
  const std::string page = Page(), readme = TextOf(HPDM_SOURCE_DIR "/tools/report/README.md");
  const Json hand = Figures()["hands"][0];
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
  const Json strict = Figures("--force-limit 0.5"), lax = Figures("--force-limit 9");
  EXPECT_GT(strict["hands"][1]["over_limit_s"], 0);
  EXPECT_GT(strict["hands"][1]["over_limit_count"], 0);
  EXPECT_EQ(lax["hands"][1]["over_limit_s"], 0);
  EXPECT_NE(Page("--force-limit 0.5").find("above the force limit of 0.5 N"), std::string::npos);
  EXPECT_EQ(Hpdm("report " + Recorded() + " --force-limit 0").exit_code, 2);
}

TEST_F(ReportTest, StandsBesideAnotherSession) {
  const std::string page = Page("--against " + Recorded());
  EXPECT_NE(page.find("compared with"), std::string::npos);
  EXPECT_NE(page.find(">0\u00a0%<"), std::string::npos);  // with itself nothing has changed
  const Json figures = Figures("--against " + Recorded());
  EXPECT_EQ(figures["against"]["hands"], figures["hands"]);
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
  EXPECT_EQ(TextOf(log), TextOf(Recorded() + "/session.lcmlog"));
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
  EXPECT_NE(report.err.find("writable"), std::string::npos);
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
  const std::string page = TextOf(page_);
  EXPECT_NE(page.find("torn off"), std::string::npos);
  EXPECT_NE(page.find("a bare log"), std::string::npos);
}

TEST_F(ReportTest, NoPrefixAndNoFlippedByteIsTooMuch) {
  const std::string bytes = TextOf(Recorded() + "/session.lcmlog").substr(0, 600'000);
  const std::string log = folder_ / "damaged.lcmlog";
  std::mt19937 random(11);
  const auto report = [&](const std::string& damaged) {
    std::ofstream(log, std::ios::binary) << damaged;
    try {
      const SessionReading reading = ReadSession(log);
      const SessionFiles files = FindSessionFiles(log);
      EXPECT_LT(ReportPageText(reading, files).size(), 5'000'000u);
      EXPECT_FALSE(reading.report.health.Sound());  // the end is missing in all of them
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

TEST_F(ReportTest, NothingOutsideOfTheFolderIsRead) {
  const fs::path folder = folder_ / "session", secret = folder_ / "secret.png";
  fs::copy(Recorded(), folder, fs::copy_options::recursive);
  std::ofstream(secret, std::ios::binary) << "\x89PNG\r\n\x1a\nsecret";
  std::ofstream(folder / "last.png", std::ios::binary) << "\x89PNG\r\n\x1a\nshown";
  std::ofstream(folder / "summary.json") << "{\"scene\": 7}";
  fs::create_symlink(secret, folder / "deepest.png");
  fs::create_directory_symlink(folder_.path(), folder / "frames");
  SessionFiles files = FindSessionFiles(folder);
  LoadPictures(&files);
  ASSERT_EQ(files.pictures.size(), 1u);
  EXPECT_EQ(files.pictures[0].name, "last.png");
  EXPECT_EQ(files.scene, "");
}

TEST(Thin, KeepsThePeaksAndTheOrder) {
  std::mt19937 random(1);
  std::vector<float> values(100'000);
  for (float& value : values) value = static_cast<float>(random() % 1000);
  values[77'777] = 5000;
  const ThinnedCurve curve = Thin(values, 0.005, 3000);
  EXPECT_LE(curve.values.size(), 3000u);
  EXPECT_GE(curve.values.size(), 2900u);
  EXPECT_TRUE(std::is_sorted(curve.times.begin(), curve.times.end()));
  const auto peak = std::max_element(curve.values.begin(), curve.values.end());
  EXPECT_EQ(*peak, 5000);
  EXPECT_NEAR(curve.times[static_cast<std::size_t>(peak - curve.values.begin())], 77'777 * 0.005,
              1e-9);
  EXPECT_EQ(Thin(std::span(values).first(1000), 0.005, 3000).values.size(), 1000u);
}

TEST(EscapeHtml, LeavesNoMarkupAndNoBrokenText) {
  EXPECT_EQ(EscapeHtml("<b a='x'>\"&\"</b>"), "&lt;b a=&#39;x&#39;&gt;&quot;&amp;&quot;&lt;/b&gt;");
  EXPECT_EQ(EscapeHtml("Gr\u00f6\u00dfe"), "Gr\u00f6\u00dfe");
  EXPECT_EQ(EscapeHtml("a\xff\xc0\xaf\xed\xa0\x80z"), "a\ufffd\ufffd\ufffd\ufffd\ufffd\ufffdz");
  EXPECT_EQ(EscapeHtml(std::string("a\0b", 3)), "a\ufffdb");
}

constexpr char kHostile[] =
    "</script><script>window.hit = 1</script><!--\u2028<img src=x onerror=hit=1>\xff";

/// A session whose instrument, organ and events are named to break a page.
SessionReading HostileSession(const std::string& log) {
  SpscQueue<HapticSample> samples(1024);
  SpscQueue<StepSample> steps(16);
  TripleBuffer<SceneSnapshot> scenes;
  SessionInfo info;
  info.instruments = {kHostile};
  OrganDescription organ;
  organ.name = kHostile;
  organ.vertices = Points::Random(4, 3) * 0.1;
  organ.triangles = Triangles::Zero(2, 3);
  organ.triangles << 0, 1, 2, 0, 2, 3;
  info.organs = {organ};
  TelemetryLoop telemetry(&samples, &steps, &scenes, log, {}, info);
  telemetry.AddEvent(EventSeverity::kError, kHostile, kHostile);
  for (int tick = 0; tick < 1000; ++tick) {
    HapticSample sample;
    sample.tick = static_cast<std::uint64_t>(tick);
    sample.time_ns = tick * 1'000'000;
    sample.tool_count = 1;
    sample.paused = tick >= 400 && tick < 600;
    sample.tools[0].p_tip_W.x() = 0.05 * std::sin(0.01 * tick);
    sample.tools[0].force_W.z() = 4;
    sample.tools[0].kind = ContactKind::kPress;
    sample.tools[0].organ = 0;
    sample.tools[0].device_valid = true;
    samples.Push(sample);
    telemetry.Drain();
  }
  telemetry.Finish();
  SessionReading reading = ReadSession(log);
  reading.report.scene = kHostile;
  return reading;
}

TEST(ReportPage, HostileNamesStayText) {
  const ScratchFolder folder;
  const std::string log = folder / "hostile.lcmlog";
  const SessionReading reading = HostileSession(log);
  const std::string page = ReportPageText(reading, FindSessionFiles(log));
  EXPECT_EQ(page.find("<script>window.hit"), std::string::npos);
  EXPECT_EQ(page.find("<img src=x"), std::string::npos);
  EXPECT_NE(page.find("&lt;script&gt;window.hit"), std::string::npos);
  EXPECT_EQ(page.find('\xff'), std::string::npos);
}

class ReportInBrowser : public ReportTest {
 protected:
  void SetUp() override {
    if (const std::string why = Browser::WhyMissing(); !why.empty()) GTEST_SKIP() << why;
  }
};

TEST_F(ReportInBrowser, DrawsEverythingAndAsksForNothing) {
  Page();
  Browser browser(1280, 900);
  browser.Open("file://" + page_);
  EXPECT_TRUE(browser.WaitFor("document.querySelector('#view canvas')"));
  EXPECT_EQ(browser.Execute("return document.querySelectorAll('#curves canvas').length"), 4);
  EXPECT_EQ(browser.Text("h1"), "two hands on a liver");
  const Json figures = Figures();
  // As a reader sees it, and as the page's own data has it.
  char shown[32];
  std::snprintf(shown, sizeof shown, "%.2f\u00a0N",
                figures["hands"][1]["peak_force_N"].get<double>());
  EXPECT_EQ(browser.Text("[data-key='hands.1.peak_force_N']"), shown);
  EXPECT_EQ(browser.Execute("return JSON.parse(data.textContent).report.hands"), figures["hands"]);
  // The path's colours: something is drawn that is neither ground nor grey.
  EXPECT_GT(browser
                .Execute(R"(
      const source = document.querySelector('#view canvas');
      const copy = document.createElement('canvas');
      [copy.width, copy.height] = [source.width, source.height];
      const context = copy.getContext('2d');
      context.drawImage(source, 0, 0);
      const pixels = context.getImageData(0, 0, copy.width, copy.height).data;
      let coloured = 0;
      for (let i = 0; i < pixels.length; i += 4) {
        if (pixels[i + 3] > 200 && Math.abs(pixels[i] - pixels[i + 1]) > 20) ++coloured;
      }
      return coloured;)")
                .get<int>(),
            500);
  browser.Click("#metrics a[href='#def-economy_of_motion']");
  EXPECT_EQ(browser.Execute("return location.hash"), "#def-economy_of_motion");
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
  for (const std::string& request : browser.Requests()) {
    EXPECT_TRUE(request.starts_with("file://" + page_)) << request;
  }
}

TEST_F(ReportInBrowser, FitsAPhoneAndTheDark) {
  // A long word, as paths are.
  const fs::path far = folder_ / std::string(100, 'w');
  fs::copy(Recorded(), far, fs::copy_options::recursive);
  Page("--against " + far.string());
  Browser browser;
  browser.Resize(390, 844);
  browser.UseDarkColours(true);
  browser.Open("file://" + page_);
  EXPECT_TRUE(browser.WaitFor("document.querySelector('#view canvas')"));
  EXPECT_TRUE(browser.WaitFor("document.documentElement.scrollWidth <= 390"));
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

TEST_F(ReportInBrowser, ShowsFlatPathsWithoutWebGl) {
  Page();
  Browser browser(1280, 900, {"--disable-3d-apis"});
  browser.Open("file://" + page_);
  EXPECT_TRUE(browser.WaitFor("document.querySelectorAll('#view svg').length === 3"));
  EXPECT_NE(browser.Text("#view").find("no WebGL"), std::string::npos);
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

TEST_F(ReportInBrowser, RunsNothingThatANameSays) {
  const std::string log = folder_ / "hostile.lcmlog";
  const SessionReading reading = HostileSession(log);
  std::ofstream(page_, std::ios::binary) << ReportPageText(reading, FindSessionFiles(log));
  Browser browser;
  browser.Open("file://" + page_);
  EXPECT_TRUE(browser.WaitFor("document.querySelector('#view canvas, #view svg')"));
  EXPECT_EQ(browser.Execute("return window.hit === undefined"), true);
  EXPECT_NE(browser.Text("h1").find("</script><script>window.hit = 1"), std::string::npos);
  EXPECT_EQ(browser.Execute("return document.querySelectorAll('img').length"), 0);
  EXPECT_NE(browser.Text("#curves .legend").find("pause"), std::string::npos);
  EXPECT_EQ(browser.Errors(), std::vector<std::string>());
}

}  // namespace
}  // namespace hpdm
