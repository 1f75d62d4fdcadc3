// The page of hpdm report: its curves, hostile names, and how a real browser shows it.

#include "tools/report/page/report_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "lcmtypes/telemetry/telemetry_loop.h"
#include "tests/support/browser.h"
#include "tests/support/recorded_report.h"
#include "tools/report/page/html_text.h"
#include "tools/report/page/page_data.h"

namespace hpdm {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

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
  const Json results = Results();
  // Compares the visible page with the page's own data.
  char shown[32];
  std::snprintf(shown, sizeof shown, "%.2f\u00a0N",
                results["hands"][1]["peak_force_N"].get<double>());
  EXPECT_EQ(browser.Text("[data-key='hands.1.peak_force_N']"), shown);
  EXPECT_EQ(browser.Execute("return JSON.parse(data.textContent).report.hands"), results["hands"]);
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
  // Every column can be read without scrolling sideways.
  EXPECT_EQ(browser.Execute(R"(
      return [...document.querySelectorAll('.wide, .hands')]
          .filter((table) => table.scrollWidth > table.clientWidth)
          .map((table) => table.closest('section').id);)"),
            Json::array());
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
