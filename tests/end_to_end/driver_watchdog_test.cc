// The force of an external driver when its session ends, on the real clock and a network of its
// own: the program and tools/driver/example_driver.cc as a user starts them.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <lcm/lcm-cpp.hpp>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hpdm/device_t.hpp"
#include "hpdm/force_t.hpp"
#include "lcmtypes/analysis/channel_table.h"
#include "lcmtypes/live/network.h"
#include "lcmtypes/wire/codec.h"
#include "tests/support/liver_scene.h"
#include "tests/support/network_namespace.h"
#include "tests/support/program.h"
#include "tests/support/scratch_folder.h"

namespace hpdm {
namespace {

using Clock = std::chrono::steady_clock;  // the driver's too

constexpr Nanoseconds kMs = 1'000'000;
constexpr Nanoseconds kWatchdog = 50 * kMs;  // haptics/README.md: a driver's duty
constexpr Nanoseconds kPeriod = kMs;         // the example's
constexpr double kPress = 0.3;               // N

Nanoseconds Now() { return Clock::now().time_since_epoch() / std::chrono::nanoseconds(1); }

struct Heard {
  std::vector<device_t> readings;
  std::vector<force_t> forces;
};

void HearReading(const lcm::ReceiveBuffer*, const std::string&, const device_t* reading,
                 Heard* heard) {
  heard->readings.push_back(*reading);
}
void HearForce(const lcm::ReceiveBuffer*, const std::string&, const force_t* force, Heard* heard) {
  heard->forces.push_back(*force);
}

/// The effort of the example driver's motor, N, computed from its hand's motion. Its law of motion
/// (Hand::Step) is m v' = pull(t, x, v) + effort with v' and x' over steps of 1 ms: two positions
/// give a velocity, three an acceleration.
struct Motor {
  Nanoseconds time = 0;  // of the reading
  double effort = 0;
};
std::vector<Motor> MotorOf(const std::vector<device_t>& readings) {
  constexpr double kDt = 1e-3, kMass = 0.3, kStiffness = 300, kDamping = 6;
  std::vector<Motor> motor;
  for (std::size_t i = 2; i < readings.size(); ++i) {
    const device_t &a = readings[i - 2], &b = readings[i - 1], &c = readings[i];
    if (c.sequence != b.sequence + 1 || b.sequence != a.sequence + 1) continue;
    const double t = kDt * static_cast<double>(c.sequence);
    const double x = b.joints[2], v = (x - a.joints[2]) / kDt, v_next = (c.joints[2] - x) / kDt;
    const double target = 0.14 + 0.035 * std::sin(3 * t), speed = 0.105 * std::cos(3 * t);
    const double pull = kStiffness * (target - x) + kDamping * (speed - v);
    motor.push_back({c.time_ns, kMass * (v_next - v) / kDt - pull});
  }
  return motor;
}
// Four roundings of a position, 3e-17 m, times m / dt^2 and the smaller d / dt: below 1e-10 N.
constexpr double kRounding = 1e-9;

class DriverWatchdog : public testing::Test {
 protected:
  // True inside the namespace. Outside it starts the test again there.
  bool Enter() {
    if (InsideNetworkNamespace()) return true;
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    const std::string enter = NetworkNamespaceCommand();
    if (enter.empty()) {
      [] { GTEST_SKIP() << "network namespaces are refused here"; }();
      return false;
    }
    EXPECT_EQ(
        RunInNetworkNamespace(enter, std::string(test->test_suite_name()) + "." + test->name()), 0);
    return false;
  }

  // Starts session and driver, and returns while a press grows.
  void StartAndPress() {
    std::ofstream(folder_ / "scene.toml")
        << kMetricLiver + kRearSupport +
               "[[instrument]]\nname = \"probe\"\ntrocar = [0.08, -0.05, 0.20]\n";
    ears_ = std::make_unique<lcm::LCM>(kLocalUrl);
    ASSERT_TRUE(ears_->good());
    ears_->subscribeFunction(kDeviceChannel, HearReading, &heard_)->setQueueCapacity(0);
    ears_->subscribeFunction(kForceChannel, HearForce, &heard_)->setQueueCapacity(0);
    session_ = std::make_unique<BackgroundCommand>(
        "exec " + kHpdmProgram + " run " + (folder_ / "scene.toml") +
            " --device lcm --no-pictures --json --out " + (folder_ / "s"),
        folder_ / "out", folder_ / "err");
    driver_ = std::make_unique<BackgroundCommand>(
        std::string("exec ") + HPDM_BINARY_DIR "/tools/hpdm_example_driver", folder_ / "driver_out",
        folder_ / "driver_err");
    // The limit is for a loaded machine; usual times are far shorter.
    EXPECT_TRUE(HearUntil([this] { return PressGrows(); }, 60'000 * kMs)) << session_->err();
  }

  // True if the newest force is a press that has grown over the last ten ticks. A force that was heard
  // late, or one of a tool that leaves, may be gone a few milliseconds later.
  bool PressGrows() {
    constexpr std::size_t kTicks = 10;
    while (ears_->handleTimeout(0) > 0) {
    }
    if (heard_.forces.size() <= kTicks) return false;
    const auto effort = [this](std::size_t ago) {
      return std::abs(
          (heard_.forces.end() - 1 - static_cast<std::ptrdiff_t>(ago))->tools[0].effort[2]);
    };
    return effort(0) > kPress && effort(0) > effort(kTicks);
  }

  template <typename Done>
  bool HearUntil(const Done& done, Nanoseconds patience) {
    const Nanoseconds end = Now() + patience;
    while (!done()) {
      if (Now() > end) return false;
      ears_->handleTimeout(1);
    }
    return true;
  }

  const ScratchFolder folder_;
  std::unique_ptr<lcm::LCM> ears_;
  std::unique_ptr<BackgroundCommand> session_, driver_;
  Heard heard_;
};

TEST_F(DriverWatchdog, AfterTheSessionIsKilledTheMotorShowsNoForceWithinFiftyMilliseconds) {
  if (!Enter()) return;
  StartAndPress();
  if (HasFailure()) return;
  session_->Signal(SIGKILL);
  const Nanoseconds killed = Now();
  ASSERT_TRUE(HearUntil([&] { return heard_.readings.back().time_ns > killed + 6 * kWatchdog; },
                        60'000 * kMs));

  // On a busy machine the driver can be kept from running, and get the last force late. Neither is
  // its watchdog's delay.
  Nanoseconds longest_gap = kPeriod;
  for (std::size_t i = 1; i < heard_.readings.size(); ++i) {
    if (heard_.readings[i].time_ns < killed - kWatchdog) continue;
    longest_gap =
        std::max(longest_gap, heard_.readings[i].time_ns - heard_.readings[i - 1].time_ns);
  }
  const std::vector<Motor> motors = MotorOf(heard_.readings);
  Nanoseconds last_force = killed;  // when the driver took the last force from the session
  double before_kill = 0, last_effort = 0;
  for (const Motor& motor : motors) {
    if (motor.time < killed) before_kill = motor.effort;
    const bool changed = std::abs(motor.effort - last_effort) > kRounding;
    if (changed && std::abs(motor.effort) > kRounding) {
      last_force = std::max(last_force, motor.time);
    }
    last_effort = motor.effort;
  }
  EXPECT_GT(std::abs(before_kill), kPress / 2) << "there was a force to take away";
  const Nanoseconds deadline = last_force + kWatchdog + longest_gap;
  int free = 0;
  for (const Motor& motor : motors) {
    if (motor.time < deadline) continue;
    EXPECT_NEAR(motor.effort, 0, kRounding)
        << static_cast<double>(motor.time - killed) / kMs << " ms after the session's end";
    ++free;
  }
  EXPECT_GT(free, 100);
}

TEST_F(DriverWatchdog, AfterTheSessionIsAskedToEndItsForcesRampToZero) {
  if (!Enter()) return;
  StartAndPress();
  if (HasFailure()) return;
  session_->Signal(SIGTERM);
  ASSERT_TRUE(HearUntil(
      [this] {
        const double* effort = heard_.forces.back().tools[0].effort;
        return effort[0] == 0 && effort[1] == 0 && effort[2] == 0;
      },
      60'000 * kMs));
  ASSERT_EQ(session_->Wait(), 0) << session_->err();
  const auto summary = nlohmann::json::parse(session_->out());
  const auto last_tick = summary["haptic"]["ticks"].get<std::int64_t>() +
                         summary["haptic"]["skipped"]["total"].get<std::int64_t>() - 1;
  std::vector<double> ramp;  // N, along the insertion, from the last tick of the session on
  for (const force_t& force : heard_.forces) {
    if (force.tick >= last_tick) ramp.push_back(std::abs(force.tools[0].effort[2]));
  }
  ASSERT_GT(ramp.size(), 1u);
  EXPECT_GT(ramp.front(), kPress / 2);
  for (std::size_t i = 1; i < ramp.size(); ++i) EXPECT_LT(ramp[i], ramp[i - 1]) << i;
  EXPECT_EQ(ramp.back(), 0);
  EXPECT_GT(heard_.forces.back().tick, last_tick)
      << "of the ramp-out, before the link's last words";
}

}  // namespace
}  // namespace hpdm
