#include "tools/session/run_summary.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace hpdm {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson TenSeconds() {
  return {{"scene", "liver"},
          {"seconds", 10.0},
          {"ended_by", "length"},
          {"haptic",
           {{"ticks", 10000},
            {"skipped", {{"total", 0}, {"late_wake_up", 0}, {"long_compute", 0}, {"stalled", 0}}}}},
          {"tools",
           {{{"name", "probe"},
             {"peak_force_N", 0.861},
             {"contact_time_s", 3.0},
             {"deepest_press_m", 0.0083}},
            {{"name", "hook"},
             {"peak_force_N", 0.0},
             {"contact_time_s", 0.0},
             {"deepest_press_m", 0.0}}}},
          {"log", {{"ticks_lost", 0}}}};
}

TEST(BriefSummary, NamesTimePeaksFolderAndTheNextCommand) {
  EXPECT_EQ(BriefSummary(TenSeconds(), "out/session_1", "build/tools/hpdm"),
            "liver: 10.0 s\n"
            "peak: probe 0.86 N, 8.3 mm deep; hook touched nothing\n"
            "session folder: out/session_1\n"
            "next: build/tools/hpdm report out/session_1\n");
}

TEST(BriefSummary, NamesTheLimitThatAPeakIsAbove) {
  const auto with = [](double force, double depth) {
    return BriefSummary(TenSeconds(), "s", "hpdm", {.force = force, .depth = depth});
  };
  EXPECT_EQ(with(0.861, 0.0083).find("limit"), std::string::npos) << "at the limit is not above it";
  EXPECT_NE(
      with(3, 0.005).find("\npeak: probe 0.86 N, 8.3 mm deep (above the limit of 5 mm); hook"),
      std::string::npos)
      << with(3, 0.005);
  EXPECT_NE(with(0.5, 0.02).find("\npeak: probe 0.86 N (above the limit of 0.5 N), 8.3 mm deep;"),
            std::string::npos)
      << with(0.5, 0.02);
}

TEST(BriefSummary, NamesMissedTicksAndTheirCausesIfThereAreAny) {
  OrderedJson summary = TenSeconds();
  summary["haptic"]["ticks"] = 9988;
  summary["haptic"]["skipped"] = {
      {"total", 12}, {"late_wake_up", 10}, {"long_compute", 2}, {"stalled", 0}};
  const std::string text = BriefSummary(summary, "s", "hpdm");
  EXPECT_NE(text.find("\nticks missed: 12 of 10,000: late wake-up 10, long computing 2, CPU steal "
                      "0\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 5);
}

TEST(BriefSummary, ASessionThatTheUserEndedIsNotCalledInterrupted) {
  OrderedJson summary = TenSeconds();
  summary["ended_by"] = "user";
  const std::string text = BriefSummary(summary, "s", "hpdm");
  EXPECT_TRUE(text.starts_with("liver: 10.0 s, ended by you\n")) << text;
  EXPECT_EQ(text.find("interrupted"), std::string::npos);
}

TEST(BriefSummary, ReportsLossesOfTheLogAndOfThePicture) {
  OrderedJson summary = TenSeconds();
  summary["log"]["ticks_lost"] = 1234;
  summary["render"]["failure"] = "the context was lost";
  const std::string text = BriefSummary(summary, "s", "hpdm");
  EXPECT_NE(text.find("\nlog: 1,234 ticks lost\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\npicture: the context was lost\n"), std::string::npos) << text;
}

TEST(BriefSummary, QuotesAFolderForTheShell) {
  const std::string text = BriefSummary(TenSeconds(), "my out/it's", "hpdm");
  EXPECT_NE(text.find("session folder: my out/it's\n"), std::string::npos) << text;
  EXPECT_NE(text.find("next: hpdm report 'my out/it'\\''s'\n"), std::string::npos) << text;
}

}  // namespace
}  // namespace hpdm
