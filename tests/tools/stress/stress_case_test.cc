#include "tools/stress/stress_case.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "engine/base/error.h"
#include "tools/stress/stress_cases.h"
#include "tools/stress/stress_report.h"

namespace hpdm {
namespace {

// Fails from `boundary` on; its error is the value over 100.
StressCase Breaking(double boundary, StressParameter parameter) {
  StressCase stress_case;
  stress_case.name = "breaking";
  stress_case.group = "motion";
  stress_case.title = "Something, \"bent\"";
  stress_case.parameter = std::move(parameter);
  stress_case.models = {StressModel::kStrainSmall};
  stress_case.run = [boundary](StressModel, double value) {
    StressTrial trial = Judge(value / 100, 0.2, boundary / 100);
    if (trial.fate == StressFate::kFailed) trial.how = "broken";
    return trial;
  };
  return stress_case;
}

StressParameter Lift() { return {"lift", "mm", 1, 40, 200}; }

TEST(StressCase, JudgesAnErrorThatIsNotANumberAsFailed) {
  EXPECT_EQ(Judge(0.1, 0.2, 0.5).fate, StressFate::kSurvived);
  EXPECT_EQ(Judge(0.2, 0.2, 0.5).fate, StressFate::kDegraded);
  EXPECT_EQ(Judge(0.5, 0.2, 0.5).fate, StressFate::kFailed);
  EXPECT_EQ(Judge(std::numeric_limits<double>::quiet_NaN(), 0.2, 0.5).fate, StressFate::kFailed);
}

TEST(StressCase, FindsTheBoundaryBeyondTheRequestByBisection) {
  const StressResult result = Examine(Breaking(100, Lift()), StressModel::kStrainSmall, 6);
  EXPECT_EQ(result.asked.fate, StressFate::kDegraded);
  EXPECT_LT(*result.holds_to, 100);
  EXPECT_GE(*result.fails_from, 100);
  EXPECT_NEAR(*result.fails_from - *result.holds_to, 160. / 64, 1e-9) << "six halvings";
  EXPECT_EQ(result.trials, 8);
}

TEST(StressCase, FindsTheBoundaryBelowTheRequest) {
  const StressResult result = Examine(Breaking(10, Lift()), StressModel::kStrainSmall, 6);
  EXPECT_EQ(result.asked.fate, StressFate::kFailed);
  EXPECT_EQ(result.fails_how, "broken");
  EXPECT_LT(*result.holds_to, 10);
  EXPECT_GE(*result.fails_from, 10);
}

TEST(StressCase, SaysWhereThereIsNoBoundary) {
  const StressResult sound = Examine(Breaking(1e3, Lift()), StressModel::kStrainSmall, 6);
  EXPECT_FALSE(sound.fails_from.has_value());
  EXPECT_EQ(sound.trials, 2);
  const StressResult hopeless = Examine(Breaking(0.5, Lift()), StressModel::kStrainSmall, 6);
  EXPECT_FALSE(hopeless.holds_to.has_value());
  EXPECT_EQ(hopeless.trials, 2);
}

TEST(StressCase, HalvesRatiosOnALogarithmicScaleEvenDownwards) {
  const StressParameter distance{"distance", "m", 1e-1, 1e-6, 1e-12, true};
  EXPECT_DOUBLE_EQ(Between(distance, 1e-6, 1e-12, 0.5), 1e-9);
  EXPECT_DOUBLE_EQ(Between(Lift(), 40, 200, 0.5), 120);
}

TEST(StressCase, ARefusalIsAFailureThatSaysWhy) {
  StressCase refusing = Breaking(1e3, Lift());
  refusing.run = [](StressModel, double value) {
    if (value > 30) throw InputError("organ 'x': too thin");
    return StressTrial();
  };
  const StressResult result = Examine(refusing, StressModel::kStrainSmall, 3);
  EXPECT_EQ(result.asked.fate, StressFate::kFailed);
  EXPECT_EQ(result.asked.how, "refused: organ 'x': too thin");
}

TEST(StressCase, RemembersHarmOfAnyTrialWithItsValue) {
  StressCase harmful = Breaking(1e3, Lift());
  harmful.run = [](StressModel, double value) {
    StressTrial trial;
    if (value > 100) trial.harm = "not finite";
    return trial;
  };
  const StressRow row{harmful, {Examine(harmful, StressModel::kStrainSmall, 3)}};
  EXPECT_EQ(row.results[0].harm, "not finite at 200 mm");
  EXPECT_EQ(Harms({row}).size(), 1u);
  EXPECT_TRUE(Examine(harmful, StressModel::kMassSpring, 3).harm.empty()) << "a baseline may break";
}

TEST(StressReport, CsvHasALineForEachCaseAndModelWithItsTextQuoted) {
  const StressCase stress_case = Breaking(100, Lift());
  StressRow row{stress_case, {Examine(stress_case, StressModel::kStrainSmall, 2)}};
  row.results.push_back(row.results[0]);
  std::istringstream lines(StressCsv({row}));
  std::string names, first;
  std::getline(lines, names);
  std::getline(lines, first);
  EXPECT_EQ(names.rfind("case,group,title,parameter,unit,easy,asked,utmost,model,fate,error", 0),
            0u);
  EXPECT_EQ(first.rfind("breaking,motion,\"Something, \"\"bent\"\"\",lift,mm,1.0,40.0,200.0,"
                        "strain_small,degraded,0.4,",
                        0),
            0u)
      << first;
}

TEST(StressReport, MarkdownHasAColumnForEachModelThatWasRun) {
  const StressCase stress_case = Breaking(100, Lift());
  const StressRow row{stress_case, {Examine(stress_case, StressModel::kStrainSmall, 0)}};
  EXPECT_EQ(StressMarkdown({row}),
            "| case and its parameter | strain, small |\n|---|---|\n"
            "| Something, \"bent\": lift 40 mm | degraded, 40 %; to 40 mm |\n");
}

TEST(StressCases, HaveNamesOfTheirOwnAndAParameterThatGrowsHarder) {
  std::set<std::string> names;
  for (const bool quick : {true, false}) {
    for (const std::vector<StressCase>& group :
         {MaterialStress(quick), ContactStress(quick), MotionStress(quick), HapticStress(quick),
          TouchStress(quick), OrganStress(quick), PartStress(quick)}) {
      for (const StressCase& each : group) {
        EXPECT_EQ(names.insert(each.name + (quick ? " quick" : "")).second, true) << each.name;
        EXPECT_FALSE(each.models.empty()) << each.name;
        const StressParameter& p = each.parameter;
        EXPECT_GE((p.asked - p.easy) * (p.utmost - p.easy), 0) << each.name;
        EXPECT_GE(std::abs(p.utmost - p.easy), std::abs(p.asked - p.easy)) << each.name;
        EXPECT_GT(p.logarithmic ? std::min(p.easy, p.utmost) : 1, 0) << each.name;
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
