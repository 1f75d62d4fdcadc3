#pragma once

#include <cstdint>

#include "engine/threads/triple_buffer.h"
#include "haptics/device/switched_device.h"

namespace hpdm {

/// A device whose driver runs elsewhere. The driver's link writes its readings into a triple
/// buffer. The forces leave with the haptic loop's samples (HapticLoop::Edges::link).
///
///     driver --> link --DeviceSample, latest--> [ExternalDevice] --> haptic loop
///       ^          ^                                                     |
///       '----------'---------------HapticSample, every tick--------------'
///
/// Watchdog, by the session times of the Reads alone:
/// 1. Without a new reading the last pose is held. After kHeldAfter the haptic loop lets its
///    velocity fade.
/// 2. After kLostAfter the pose is invalid, and the force guard fades the force out.
/// 3. The next usable reading makes the pose valid again, and the guard ramps the force in.
///
/// A reading that is marked invalid or not finite makes the device invalid until the next usable
/// one. Joints beyond the workspace are clamped to it. Home() homes only the force switch; the driver
/// homes its own axes before it publishes.
class ExternalDevice : public SwitchedDevice {
 public:
  static constexpr Nanoseconds kLostAfter = 50'000'000;

  explicit ExternalDevice(const DeviceLimits& limits) : limits_(limits) {}

  /// The buffer for the link's readings, with times in session time. One writer.
  TripleBuffer<DeviceSample>& readings() { return readings_; }

  DeviceSample Read(Nanoseconds now) noexcept override;
  /// Does nothing: the driver takes the effort from the haptic sample, 0 while ForceOn() is false.
  void Write(const AxisEffort&) noexcept override {}
  DeviceLimits limits() const noexcept override { return limits_; }

 private:
  DeviceLimits limits_;
  TripleBuffer<DeviceSample> readings_;
  DeviceSample sample_;         // the last usable one
  bool usable_ = false;         // the newest reading is usable
  Nanoseconds arrived_ns_ = 0;  // time of the Read that found the newest reading
};

}  // namespace hpdm
