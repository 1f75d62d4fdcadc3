// Faulty device samples in the haptic loop: tests/bad_input/device_samples.csv. For every sample
// the force stays finite, within the device's limit and within the slew limit (FaultBench),
// and a recovered device gets the same force as before.

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <map>
#include <random>

#include "tests/bad_input/bad_input.h"
#include "tests/support/fault_bench.h"

namespace hpdm {
namespace {

constexpr int kFaultTicks = 100;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNotANumber = std::numeric_limits<double>::quiet_NaN();
constexpr Nanoseconds kLast = std::numeric_limits<Nanoseconds>::max();

JointVector Sound() { return At(0, -0.005); }

/// Two ways into the loop: a device of this program, and a driver's readings.
struct Input {
  /// Tick 0 to 99 of the fault, at `now`.
  std::function<void(int tick, Nanoseconds now, RawDevice* device)> raw;
  std::function<void(int tick, Nanoseconds now, External* external)> external;
};

Input Joint(int axis, double value) {
  return {.raw = [=](int, Nanoseconds, RawDevice* d) { d->sample.joints[axis] = value; },
          .external = {}};
}

Input Time(std::function<Nanoseconds(int tick, Nanoseconds now)> time) {
  return {.raw =
              [=](int tick, Nanoseconds now, RawDevice* d) {
                d->frozen = true;
                d->sample.time_ns = time(tick, now);
              },
          .external = {}};
}

Input Reading(std::function<void(int tick, DeviceSample* reading)> change) {
  return {.raw = {}, .external = [=](int tick, Nanoseconds now, External* e) {
            DeviceSample& reading = e->readings->Back();
            reading = {.sequence = ++e->sequence, .time_ns = now, .joints = Sound(), .valid = true};
            change(tick, &reading);
            e->readings->Publish();
          }};
}

using Inputs = std::map<std::string, Input>;

void AddPoses(Inputs* to) {
  Inputs& inputs = *to;
  const char* const axes[] = {"pitch", "yaw", "insertion", "roll", "jaw"};
  for (int axis = 0; axis < 5; ++axis) {
    inputs[std::string(axes[axis]) + " of NaN"] = Joint(axis, kNotANumber);
    inputs[std::string(axes[axis]) + " of infinity"] = Joint(axis, kInfinity);
  }
  inputs["a pose of 1e308"] = {
      .raw = [](int, Nanoseconds, RawDevice* d) { d->sample.joints.setConstant(1e308); },
      .external = {}};
  inputs["roll and jaw beyond their ends"] = {.raw =
                                                  [](int, Nanoseconds, RawDevice* d) {
                                                    d->sample.joints[kRoll] = 1e6;
                                                    d->sample.joints[kJaw] = 7;
                                                  },
                                              .external = {}};
  inputs["a pose through the trocar"] = Joint(kInsertion, -0.4);
  inputs["a pose that jumps by 0.3 m every tick"] = {
      .raw = [](int tick, Nanoseconds,
                RawDevice* d) { d->sample.joints = tick % 2 == 0 ? At(0.3, -0.4) : Sound(); },
      .external = {}};
  inputs["a pose that jumps by 0.2 m and stays"] = {
      .raw = [](int tick, Nanoseconds,
                RawDevice* d) { d->sample.joints = tick < 50 ? Sound() : At(0.2, -0.005); },
      .external = {}};
  inputs["a pose that jumps by 0.2 m into the tissue"] = {
      .raw = [](int, Nanoseconds, RawDevice* d) { d->sample.joints = At(0, -0.205); },
      .external = {}};
  inputs["a reading that jumps by 0.2 m and back"] = Reading([](int tick, DeviceSample* r) {
    if (tick % 3 == 0) r->joints = At(0.2, -0.005);
  });
  inputs["noise over the whole workspace"] = {
      .raw =
          [random = std::mt19937(3)](int, Nanoseconds, RawDevice* d) mutable {
            for (int axis = 0; axis < 5; ++axis) {
              d->sample.joints[axis] = std::uniform_real_distribution(-1.5, 1.5)(random);
            }
          },
      .external = {}};
  inputs["no pose"] = {.raw = [](int, Nanoseconds, RawDevice* d) { d->sample.valid = false; },
                       .external = {}};
  inputs["a pose every second tick"] = {
      .raw = [](int tick, Nanoseconds, RawDevice* d) { d->sample.valid = tick % 2 == 0; },
      .external = {}};
}

void AddTimes(Inputs* to) {
  Inputs& inputs = *to;
  inputs["a time that stands still"] = Time([](int, Nanoseconds) { return Nanoseconds{0}; });
  inputs["a time that runs backwards"] =
      Time([](int tick, Nanoseconds now) { return now - 2 * tick * kMs; });
  inputs["a time of the future"] = Time([](int, Nanoseconds now) { return now + 1000 * kMs; });
  inputs["a time at the ends of time"] =
      Time([](int tick, Nanoseconds) { return tick % 2 == 0 ? kLast : -kLast - 1; });
}

void AddReadings(Inputs* to) {
  Inputs& inputs = *to;
  inputs["a driver that falls silent"] = {.raw = {},
                                          .external = [](int, Nanoseconds, External*) {}};
  inputs["a driver that floods"] = {.raw = {}, .external = [](int, Nanoseconds now, External* e) {
                                      for (int i = 0; i < 1000; ++i) e->Push(0, -0.005, now);
                                    }};
  inputs["a reading of NaN"] =
      Reading([](int, DeviceSample* r) { r->joints[kInsertion] = kNotANumber; });
  inputs["a reading that its driver calls invalid"] =
      Reading([](int, DeviceSample* r) { r->valid = false; });
  inputs["a reading outside of the workspace"] =
      Reading([](int, DeviceSample* r) { r->joints << 1e300, -1e300, -5, 1e9, 7; });
  inputs["a reading of the future"] = Reading([](int, DeviceSample* r) { r->time_ns = kLast; });
  inputs["a sequence that repeats"] = Reading([](int, DeviceSample* r) { r->sequence = 1; });
  inputs["a sequence that runs backwards"] = Reading(
      [](int tick, DeviceSample* r) { r->sequence = static_cast<std::uint64_t>(200 - tick); });
}

/// The outcome of the fault's ticks.
struct FaultOutcome {
  int without_pose = 0;       ///< Ticks.
  double share_of_force = 0;  ///< Force at the end over the force before.
  double aside = 0;           ///< m, largest distance of the tip from its place before.
};

/// A haptic loop that presses with sound samples and then gets faulty ones.
class FaultTrial {
 public:
  explicit FaultTrial(const Input& input) : input_(input) {
    raw_.sample.joints = Sound();
    if (input_.external) {
      bench_.emplace(&external_.device);
    } else {
      bench_.emplace(&raw_);
    }
  }

  /// Runs with sound samples until the force is there.
  ToolSample RunSound(int ticks) {
    ToolSample tool;
    for (int i = 0; i < ticks; ++i) {
      raw_.frozen = false;
      raw_.sample.joints = Sound();
      raw_.sample.valid = true;
      if (input_.external) external_.Push(0, -0.005, bench_->Now());
      tool = bench_->Tick();
    }
    return tool;
  }

  /// Runs kFaultTicks with the faulty samples.
  FaultOutcome RunFault(const ToolSample& before) {
    FaultOutcome seen;
    for (int i = 0; i < kFaultTicks; ++i) {
      if (input_.external) {
        input_.external(i, bench_->Now(), &external_);
      } else {
        input_.raw(i, bench_->Now(), &raw_);
      }
      const ToolSample tool = bench_->Tick();
      seen.without_pose += !tool.device_valid;
      seen.aside = std::max(seen.aside, (tool.p_tip_W - before.p_tip_W).norm());
      seen.share_of_force = tool.force_W.norm() / before.force_W.norm();
    }
    return seen;
  }

 private:
  Input input_;
  RawDevice raw_;
  External external_;
  std::optional<FaultBench> bench_;
};

TEST(BadInput, DeviceSamplesHaveTheOutcomesOfTheTable) {
  Inputs inputs;
  AddPoses(&inputs);
  AddTimes(&inputs);
  AddReadings(&inputs);
  for (const ExpectedOutcome& row : ReadOutcomes("device_samples")) {
    SCOPED_TRACE("device_samples.csv:" + std::to_string(row.line) + ": " + row.input);
    const auto input = inputs.find(row.input);
    if (input == inputs.end()) {
      ADD_FAILURE() << "no such input";
      continue;
    }
    FaultTrial trial(input->second);
    const ToolSample before = trial.RunSound(700);
    ASSERT_NEAR(before.force_W.norm(), 120 * 0.0075, 1e-9);
    const FaultOutcome seen = trial.RunFault(before);
    EXPECT_EQ(row.outcome == "refused", seen.without_pose > 0);
    // 100 ticks of the guard's 50 ms, if all of them are without a pose.
    const double let_go = std::exp(-0.02 * seen.without_pose);
    if (row.what == "the force stays") {
      EXPECT_NEAR(seen.share_of_force, 1, 1e-9);
    } else if (row.what == "the force decays at once") {
      EXPECT_NEAR(seen.share_of_force, let_go, 1e-9);
      EXPECT_EQ(seen.aside, 0) << "the last pose stands";
    } else if (row.what == "held for 50 ms, then the force decays") {
      EXPECT_NEAR(seen.without_pose, kFaultTicks - 50, 1);
      EXPECT_NEAR(seen.share_of_force, let_go, 1e-9);
      EXPECT_EQ(seen.aside, 0);
    } else if (row.what == "clamped to the workspace") {
      EXPECT_EQ(row.outcome, "repaired");
      EXPECT_LT(seen.aside, 1) << "the workspace's size";
    } else {
      EXPECT_EQ(row.what, "the force follows within its limits");
    }
    // The force returns by the guard's ramp of 0.5 s.
    const ToolSample after = trial.RunSound(700);
    EXPECT_NEAR((after.force_W - before.force_W).norm(), 0, 1e-9);
    inputs.erase(input);
  }
  for (const auto& [name, input] : inputs) ADD_FAILURE() << "no row for the input " << name;
}

}  // namespace
}  // namespace hpdm
