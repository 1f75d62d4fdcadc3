#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>

#include "haptics/device/external_device.h"
#include "tests/support/haptic_bench.h"

/// A haptic loop whose device may answer anything.
namespace hpdm {

inline constexpr Nanoseconds kMs = 1'000'000;

/// Returns the test's sample, unchecked.
class RawDevice : public FakeDevice {
 public:
  DeviceSample Read(Nanoseconds now) noexcept override {
    if (!frozen) sample.time_ns = now;
    return sample;
  }

  DeviceSample sample{.joints = JointVector::Zero(), .valid = true};
  bool frozen = false;
};

/// A loop over a plane at z = 0 with 120 N/m, in virtual time. Every tick is checked for what holds
/// under any fault.
class FaultBench {
 public:
  explicit FaultBench(Device* device)
      : loop({{device, Kinematics(), {{.tip_radius = kTipRadius}}}}, kMs,
             {tool_states, patches, samples}) {
    device->Home();
    device->EnableForce(true);
  }

  ToolSample Tick() {
    if (tick % 33 == 0) {
      ContactPatch& patch = patches.Back();
      patch = {};
      patch.step.number = tick / 33 + 1;
      patch.step.device_time_ns = Now();
      patch.tool_count = 1;
      patch.tools[0].places[0] = PlanePatch(7, 0.03, 120);
      patches.Publish();
    }
    loop.Tick(tick, Now(), {});
    ++tick;
    HapticSample sample;
    EXPECT_TRUE(samples.Pop(&sample));
    const ToolSample& tool = sample.tools[0];
    const ForceGuardOptions guard;
    EXPECT_TRUE(tool.force_W.allFinite() && tool.effort.allFinite() && tool.p_tip_W.allFinite() &&
                tool.v_tip_W.allFinite());
    // 1e-12: roundings of the vectors' lengths.
    EXPECT_LE(tool.force_W.norm(), guard.max_force * (1 + 1e-12));
    EXPECT_LE((tool.force_W - last_force).norm(), guard.max_force_rate * 1e-3 * (1 + 1e-12));
    last_force = tool.force_W;
    return tool;
  }
  ToolSample Ticks(int count) {
    ToolSample tool;
    for (int i = 0; i < count; ++i) tool = Tick();
    return tool;
  }
  Nanoseconds Now() const { return static_cast<Nanoseconds>(tick) * kMs; }

  TripleBuffer<ToolState> tool_states;
  TripleBuffer<ContactPatch> patches;
  SpscQueue<HapticSample> samples{64};
  HapticLoop loop;
  std::uint64_t tick = 0;
  Vector3d last_force = Vector3d::Zero();
};

inline JointVector At(double x, double z) { return Kinematics().Inverse({x, 0, z}, 0, 1).joints; }

/// An external device with readings as a link would put them.
struct External {
  void Push(double x, double z, Nanoseconds time) {
    readings->Back() = {.sequence = ++sequence, .time_ns = time, .joints = At(x, z), .valid = true};
    readings->Publish();
  }
  ExternalDevice device{LimitsOf({})};
  TripleBuffer<DeviceSample>* readings = &device.readings();
  std::uint64_t sequence = 0;
};

}  // namespace hpdm
