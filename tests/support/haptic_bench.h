#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "haptics/device/sim_device.h"
#include "haptics/device/simulated_hand.h"
#include "haptics/device/switched_device.h"
#include "haptics/haptic_loop.h"
#include "tests/support/contact_patches.h"

/// A haptic loop whose devices and patches the tests control.
namespace hpdm {

inline constexpr Nanoseconds kPeriod = 1'000'000;
inline constexpr double kStiffness = 120;     // N/m
inline constexpr double kTipRadius = 0.0025;  // m
inline const Vector3d kTrocar(0, 0, 0.1);     // straight above the patches' middle

inline ImpulseEngineKinematics Kinematics() {
  return {kTrocar, -Vector3d::UnitZ(), DeviceProfile{}};
}

// A device whose pose the test sets.
class FakeDevice : public SwitchedDevice {
 public:
  DeviceSample Read(Nanoseconds now) noexcept override {
    return {.sequence = ++reads_,
            .time_ns = now - age,
            .joints = joints,
            .valid = valid,
            .pedal = pedal};
  }
  void Write(const AxisEffort& effort) noexcept override { written = effort; }
  DeviceLimits limits() const noexcept override { return LimitsOf({}); }

  void MoveTip(const Vector3d& p_W) { joints = Kinematics().Inverse(p_W, 0, 1).joints; }

  JointVector joints = JointVector::Zero();
  bool valid = true;
  bool pedal = false;
  Nanoseconds age = 0;  // of its readings
  AxisEffort written = AxisEffort::Zero();

 private:
  std::uint64_t reads_ = 0;
};

// A loop with one fake device over a plane at z = 0, ticked in virtual time.
class Bench {
 public:
  explicit Bench(bool passivity_control = true, std::vector<ToolGeometry> exchanges = {}) {
    device.MoveTip({0, 0, 0.01});
    device.Home();
    device.EnableForce(true);
    HapticInstrument instrument{&device, Kinematics(), {{.tip_radius = kTipRadius}}};
    instrument.passivity.control = passivity_control;
    instrument.geometries.insert(instrument.geometries.end(), exchanges.begin(), exchanges.end());
    loop = std::make_unique<HapticLoop>(
        std::vector{instrument}, kPeriod,
        HapticLoop::Edges{tool_states, patches, samples, nullptr, &control});
  }

  void PublishPatch() {
    ContactPatch& patch = patches.Back();
    patch = {};
    patch.step.number = ++step;
    patch.step.input_tick = tick == 0 ? 0 : tick - 1;
    patch.step.device_time_ns = static_cast<Nanoseconds>(tick) * kPeriod;
    patch.tool_count = 1;
    patch.tools[0].places[0] = PlanePatch(7, 0.03, stiffness);
    patch.tools[0].instrument_index = instrument_index;
    patches.Publish();
  }

  HapticSample Tick() {
    loop->Tick(tick, static_cast<Nanoseconds>(tick) * kPeriod, {});
    ++tick;
    HapticSample sample;
    EXPECT_TRUE(samples.Pop(&sample));
    return sample;
  }

  // Runs past the ramp-in, with a new patch every 33 ticks.
  void Settle() {
    for (int i = 0; i < 600; ++i) {
      if (i % 33 == 0) PublishPatch();
      Tick();
    }
  }

  void Ask(const SessionControl& asked) {
    control.Back() = asked;
    control.Publish();
  }

  double stiffness = kStiffness;  // N/m, of the patches to come
  int instrument_index = 0;       // the instrument of the patches
  FakeDevice device;
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  TripleBuffer<SessionControl> control;
  SpscQueue<HapticSample> samples{64};
  std::unique_ptr<HapticLoop> loop;
  std::uint64_t tick = 0;
  std::uint64_t step = 0;
};

// Two simulated hands over full patches, as in a session.
struct SimulatedSession {
  SimulatedSession() {
    std::vector<HapticInstrument> instruments;
    for (int i = 0; i < kMaxInstruments; ++i) {
      HandOptions options;
      options.seed = static_cast<std::uint32_t>(i + 1);
      options.script = i == 0 ? HandScript::kPalpate : HandScript::kRandom;
      const HandSite site{Vector3d::Zero(), Vector3d::UnitZ(), kTrocar, 0.2};
      devices.push_back(std::make_unique<SimDevice>(
          DeviceProfile{}, Kinematics(), std::make_unique<SimulatedHand>(options, site)));
      devices.back()->Home();
      devices.back()->EnableForce(true);
      instruments.push_back({devices.back().get(), Kinematics(), {{.tip_radius = kTipRadius}}});
      instruments.back().geometries.push_back({.tip_radius = 0.5 * kTipRadius});
    }
    loop = std::make_unique<HapticLoop>(
        instruments, kPeriod, HapticLoop::Edges{tool_states, patches, samples, nullptr, &control});
  }

  void PublishPatch(std::uint64_t tick) {
    ContactPatch& patch = patches.Back();
    patch.step.number = ++step;
    patch.step.device_time_ns = static_cast<Nanoseconds>(tick) * kPeriod;
    patch.tool_count = kMaxInstruments;
    for (ToolPatches& tool : patch.tools) {
      tool.places[0] = SpherePatch(8, 0.04, 0.1, kStiffness);
      tool.instrument_index = instrument_index;
    }
    patches.Publish();
  }

  void Ask(const SessionControl& asked) {
    control.Back() = asked;
    control.Publish();
  }

  void Run(std::uint64_t begin, std::uint64_t end) {
    for (std::uint64_t tick = begin; tick < end; ++tick) {
      if (tick % 33 == 0) PublishPatch(tick);
      loop->Tick(tick, static_cast<Nanoseconds>(tick) * kPeriod, {});
      HapticSample sample;
      while (samples.Pop(&sample)) log.push_back(sample);
    }
  }

  int instrument_index = 0;  // the instrument of the patches to come
  std::vector<std::unique_ptr<SimDevice>> devices;
  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  TripleBuffer<SessionControl> control;
  SpscQueue<HapticSample> samples{64};
  std::unique_ptr<HapticLoop> loop;
  std::uint64_t step = 0;
  std::vector<HapticSample> log;
};

}  // namespace hpdm
