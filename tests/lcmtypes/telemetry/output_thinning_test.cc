#include "lcmtypes/telemetry/output_thinning.h"

#include <gtest/gtest.h>

#include <vector>

namespace hpdm {
namespace {

HapticSample Tick(std::uint64_t tick, double force = 0, int organ = -1) {
  HapticSample sample;
  sample.tick = tick;
  sample.tool_count = 1;
  ToolSample& tool = sample.tools[0];
  tool.force_W.z() = force;
  tool.organ = organ;
  tool.kind = organ >= 0 ? ContactKind::kPress : ContactKind::kNone;
  return sample;
}

std::vector<std::uint64_t> Selected(int interval, const std::vector<HapticSample>& samples) {
  OutputThinning thinning(interval);
  std::vector<std::uint64_t> ticks;
  for (const HapticSample& sample : samples) {
    if (thinning.Selects(sample)) ticks.push_back(sample.tick);
  }
  return ticks;
}

using Ticks = std::vector<std::uint64_t>;

TEST(OutputThinning, SelectsTheFirstTickOfEachInterval) {
  std::vector<HapticSample> samples;
  for (std::uint64_t tick = 0; tick < 12; ++tick) {
    if (tick != 5) samples.push_back(Tick(tick));  // skipped
  }
  EXPECT_EQ(Selected(5, samples), (Ticks{0, 6, 10}));
  EXPECT_EQ(Selected(1, samples).size(), samples.size());
}

TEST(OutputThinning, SelectsChangesOfContact) {
  std::vector<HapticSample> samples;
  for (const int organ : {-1, -1, 0, 0, 1, 1, -1, -1}) {
    samples.push_back(Tick(samples.size(), 0, organ));
  }
  EXPECT_EQ(Selected(100, samples), (Ticks{0, 2, 4, 6}));
}

TEST(OutputThinning, SelectsForcesThatAreSwitchedOffOrLimited) {
  std::vector<HapticSample> samples;
  for (const std::uint32_t flags :
       {0U, 0U + kGuardDisabled, 0U + kGuardDisabled, 0U + kGuardClamped, 0U, 0U + kGuardSlewed}) {
    samples.push_back(Tick(samples.size()));
    samples.back().tools[0].guard_flags = flags;
  }
  EXPECT_EQ(Selected(100, samples), (Ticks{0, 1, 3, 4}));
}

TEST(OutputThinning, SelectsTheLargestForceAndDepthAtEachOrgan) {
  std::vector<HapticSample> samples;
  for (const double force : {0.0, 2.0, 1.0, 2.0, 3.0, 3.0}) {
    samples.push_back(Tick(samples.size(), force, 0));
  }
  samples.push_back(Tick(6, 0, 1));
  samples.push_back(Tick(7, 1, 1));  // less than at the other organ
  samples.push_back(Tick(8, 1, 1));
  samples.back().tools[0].depth = 0.01;
  EXPECT_EQ(Selected(100, samples), (Ticks{0, 1, 4, 6, 7, 8}));
}

TEST(OutputThinning, TheTextOfItsEventGivesTheInterval) {
  EXPECT_EQ(ThinnedInterval(ThinnedText(10)), 10);
  EXPECT_EQ(ThinnedInterval(ThinnedText(1'000'000)), 1'000'000);
  for (const char* text :
       {"", "one output in ",
        "one output in  ticks is in the log, and each change of contact and new peak",
        "one output in -3 ticks is in the log, and each change of contact and new peak",
        "one output in 99999999999 ticks is in the log, and each change of contact and new peak"}) {
    EXPECT_EQ(ThinnedInterval(text), 1) << text;
  }
}

}  // namespace
}  // namespace hpdm
