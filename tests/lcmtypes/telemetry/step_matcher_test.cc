#include "lcmtypes/telemetry/step_matcher.h"

#include <gtest/gtest.h>

#include <utility>
#include <vector>

namespace hpdm {
namespace {

/// A matcher with the steps that it wrote: number and visible tick.
struct MatcherBench {
  void AddStep(std::int64_t number) {
    contact_t step{};
    step.step = number;
    matcher.AddStep(std::move(step));
  }
  std::vector<std::pair<std::int64_t, std::int64_t>> written;
  StepMatcher matcher{
      [this](contact_t* step) { written.emplace_back(step->step, step->visible_tick); }};
};

using Written = std::vector<std::pair<std::int64_t, std::int64_t>>;

TEST(StepMatcher, AStepIsVisibleFromTheFirstTickThatUsedIt) {
  MatcherBench bench;
  bench.AddStep(1);
  EXPECT_TRUE(bench.written.empty()) << "its use is not known yet";
  bench.matcher.AddFirstUse(1, 41);
  bench.matcher.AddFirstUse(1, 42);
  EXPECT_EQ(bench.written, (Written{{1, 41}}));
}

TEST(StepMatcher, AUseMayComeBeforeItsStep) {
  MatcherBench bench;
  bench.matcher.AddFirstUse(3, 41);
  bench.matcher.AddFirstUse(5, 70);
  for (std::int64_t number = 1; number <= 5; ++number) bench.AddStep(number);
  EXPECT_EQ(
      bench.written,
      (Written{{1, kNeverVisible}, {2, kNeverVisible}, {3, 41}, {4, kNeverVisible}, {5, 70}}));
}

TEST(StepMatcher, AStepThatWasReplacedBeforeATickUsedItIsNeverVisible) {
  MatcherBench bench;
  for (std::int64_t number = 1; number <= 3; ++number) bench.AddStep(number);
  bench.matcher.AddFirstUse(3, 41);
  bench.matcher.AddFirstUse(4, 43);  // overtakes its step
  bench.AddStep(4);
  bench.AddStep(5);
  bench.matcher.Finish();
  EXPECT_EQ(
      bench.written,
      (Written{{1, kNeverVisible}, {2, kNeverVisible}, {3, 41}, {4, 43}, {5, kNeverVisible}}));
}

TEST(StepMatcher, ALostStepDoesNotDelayTheOthers) {
  MatcherBench bench;
  bench.AddStep(1);
  bench.matcher.AddFirstUse(2, 50);  // step 2 was lost
  bench.AddStep(3);
  bench.matcher.AddFirstUse(3, 60);
  EXPECT_EQ(bench.written, (Written{{1, kNeverVisible}, {3, 60}}));
}

TEST(StepMatcher, OnlyABoundedNumberOfStepsWaits) {
  MatcherBench bench;
  const auto max = static_cast<std::int64_t>(StepMatcher::kMaxWaiting);
  for (std::int64_t number = 1; number <= max; ++number) bench.AddStep(number);
  EXPECT_TRUE(bench.written.empty());
  bench.AddStep(max + 1);
  EXPECT_EQ(bench.written, (Written{{1, kNeverVisible}}));
}

}  // namespace
}  // namespace hpdm
