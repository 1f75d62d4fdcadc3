#pragma once

#include "haptics/device/device.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// A device that returns the sample and force switch set last, as recorded in a tick, at any time.
/// It ignores written forces. One thread.
class ReplayDevice : public Device {
 public:
  explicit ReplayDevice(const DeviceLimits& limits) : limits_(limits) {}

  /// Sets the answers of the next Read and ForceOn.
  void Set(const DeviceSample& sample, bool force_on) noexcept {
    sample_ = sample;
    force_on_ = force_on;
  }
  /// Sets them from a recorded tick.
  void Set(const ToolSample& tool) noexcept {
    Set({.sequence = sample_.sequence + 1,
         .time_ns = tool.device_time_ns,
         .joints = tool.joints,
         .valid = tool.device_valid},
        tool.force_on);
  }

  DeviceSample Read(Nanoseconds /*now*/) noexcept override { return sample_; }
  void Write(const AxisEffort& /*effort*/) noexcept override {}
  void Home() override {}
  void EnableForce(bool /*on*/) noexcept override {}
  void EmergencyStop() noexcept override {}
  bool ForceOn() const noexcept override { return force_on_; }
  DeviceLimits limits() const noexcept override { return limits_; }

 private:
  DeviceLimits limits_;
  DeviceSample sample_;
  bool force_on_ = false;
};

}  // namespace hpdm
