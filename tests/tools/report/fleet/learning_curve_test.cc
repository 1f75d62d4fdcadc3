#include "tools/report/fleet/learning_curve.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/fleet_folder.h"
#include "tools/report/fleet/learning_curve_page.h"

namespace hpdm {
namespace {

using Values = std::vector<std::optional<double>>;

TEST(LearningFit, FindsThePlateauOfItsOwnLawAndPassesOverGaps) {
  Values values;
  for (int n = 1; n <= 12; ++n) values.push_back(90 - 40.0 / n);
  values[4].reset();
  const std::optional<LearningFit> fit = FitLearning(values);
  ASSERT_TRUE(fit.has_value());
  EXPECT_NEAR(fit->plateau, 90, 1e-9);
  EXPECT_NEAR(fit->drop, 40, 1e-9);
  EXPECT_NEAR(fit->explained, 1, 1e-12);
  EXPECT_NEAR(fit->sessions_to_90.value(), 400.0 / 90, 1e-9);  // 90 - 40 / n = 81
}

TEST(LearningFit, FourValuesEqualValuesAndAFallHaveNoPlateau) {
  EXPECT_FALSE(FitLearning(Values{1, 2, 3, 4, std::nullopt}).has_value());
  EXPECT_FALSE(FitLearning(Values{2, 2, 2, 2, 2}).has_value());
  const std::optional<LearningFit> fall = FitLearning(Values{5, 4, 3, 2, 1});
  ASSERT_TRUE(fall.has_value());
  EXPECT_FALSE(fall->sessions_to_90.has_value());
}

Json LineOfTask(const std::string& session, const std::string& start, double score,
                const std::string& task = "touch") {
  Json line = {{"session", session}, {"exit_code", 0}, {"log_mtime_ns", 1'700'000'000'000'000'000}};
  line["report"] = {{"scene", "a scene"},
                    {"start", start.empty() ? Json(nullptr) : Json(start)},
                    {"exercise", {{"name", task}, {"score", score}, {"time_s", 20}}},
                    {"hands",
                     {{{"path_length_m", 1}, {"peak_force_N", 2}},
                      {{"path_length_m", 0.5}, {"peak_force_N", 3}}}}};
  return line;
}

TEST(LearningCurves, ATasksSessionsAreInTheOrderOfTheirStarts) {
  const std::vector<Json> lines = {
      LineOfTask("b", "2026-02-01T10:00:00Z", 60), LineOfTask("a", "2026-03-01T10:00:00Z", 70),
      LineOfTask("c", "", 10), LineOfTask("d", "2026-01-01T10:00:00Z", 5, "another task"),
      Json{{"session", "failed"}, {"exit_code", 2}, {"error", "no log"}}};
  const std::vector<LearningCurve> curves = LearningCurves(lines);
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_EQ(curves[0].task, "another task");
  const LearningCurve& touch = curves[1];
  EXPECT_EQ(touch.names, (std::vector<std::string>{"c", "b", "a"})) << "c by its log, of 2023";
  EXPECT_EQ(touch.series[0].key, "score");
  EXPECT_EQ(touch.series[0].values, (Values{10, 60, 70}));
  for (const LearningSeries& series : touch.series) {
    if (series.key == "path_length") {
      EXPECT_EQ(series.values[0], 1.5) << "of both hands";
    }
    if (series.key == "peak_force") {
      EXPECT_EQ(series.values[0], 3.0) << "the larger";
    }
    EXPECT_NE(series.key, "efficiency") << "these sessions have none";
  }
}

TEST(LearningCurves, ThePageHasEveryValueAndNoMarkupFromNames) {
  std::vector<Json> lines;
  for (int n = 1; n <= 6; ++n) {
    lines.push_back(LineOfTask("<b>s" + std::to_string(n),
                               "2026-01-0" + std::to_string(n) + "T10:00:00Z", 80 - 30.0 / n,
                               "<script>hit</script>"));
  }
  const std::string page = LearningCurvePage(LearningCurves(lines));
  for (int n = 1; n <= 6; ++n) {
    char value[40];
    std::snprintf(value, sizeof value, "data-value=\"%.6g\"", 80 - 30.0 / n);
    EXPECT_NE(page.find(value), std::string::npos) << value;
  }
  EXPECT_NE(page.find("Plateau 80, 90 % of it from session 4 on"), std::string::npos);  // 3.75
  EXPECT_EQ(page.find("<script>hit"), std::string::npos);
  EXPECT_EQ(page.find("<b>s1"), std::string::npos);
  EXPECT_NE(LearningCurvePage({}).find("No session with a report"), std::string::npos);
}

TEST_F(FleetTest, ACurveIsOfAllSessionsAndExcludesATable) {
  AddSession("a");
  WriteAll(root_ / "a" / "summary.json", R"({"scene": "a liver"})");
  AddSession("b");
  WriteAll(root_ / "b" / "summary.json", R"({"scene": "a liver"})");
  const std::string out = folder_ / "out", page = folder_ / "curve.html";
  const auto run = [&](const std::string& words) {
    return Shell(kHpdmProgram + " report --all " + root_.string() + " " + words + " >" + out +
                 " 2>&1");
  };
  EXPECT_EQ(run("--curve " + page), 0) << ReadFile(out);
  EXPECT_NE(ReadFile(page).find("a liver: 2 sessions"), std::string::npos);
  EXPECT_EQ(run("--curve " + page + " --out " + table_), 2);
  EXPECT_NE(ReadFile(out).find("--curve cannot be combined with --out"), std::string::npos);
}

TEST_F(FleetTest, ATableHasTheExercise) {
  Json line = LineOfTask("a", "2026-02-01T10:00:00Z", 60);
  line["log_bytes"] = 1;
  line["summary_mtime_ns"] = 0;
  line["report_version"] = kReportVersion;
  line["report"]["exercise"]["passed"] = true;
  line["report"]["exercise"]["error_count"] = 3;
  line["report"]["exercise"]["restart_count"] = 2;
  OpenSessionTable(table_)->Add({&line, 1});
  const Json row = Rows(table_, "SELECT * FROM exercises").at(0);
  EXPECT_EQ(row["name"], "touch");
  EXPECT_EQ(row["score"], 60);
  EXPECT_EQ(row["passed"], 1);
  EXPECT_EQ(row["error_count"], 3);
  EXPECT_EQ(row["restart_count"], 2);
}

}  // namespace
}  // namespace hpdm
