#pragma once

#include <atomic>
#include <cstdint>
#include <memory>

#include "engine/snapshots.h"

namespace hpdm {

/// Limits of a device. Units as in JointVector: rad, rad, m, rad, and 1 for the jaw.
struct DeviceLimits {
  double max_force = 0;                             ///< N, at the tip and on the insertion axis.
  double max_torque = 0;                            ///< N m, on the pitch and the yaw axis.
  double max_force_rate = 0;                        ///< N/s.
  JointVector min_joints = JointVector::Zero();     ///< Workspace.
  JointVector max_joints = JointVector::Zero();     ///< Workspace.
  JointVector encoder_steps = JointVector::Zero();  ///< One count of each axis; 0: continuous.
};

/// A device whose newest reading is older than this is assumed to stand still.
inline constexpr Nanoseconds kHeldAfter = 5'000'000;

/// The three conditions under which a device displays force: homed, enabled, and no emergency stop
/// since it was homed. Every Device holds one.
///
/// The count of presses is atomic, since a stop must work from any thread and from a signal
/// handler. Homing stores the count that it saw, so a press during homing stays in force.
class ForceSwitch {
 public:
  ForceSwitch() = default;
  ForceSwitch(const ForceSwitch& other)
      : presses_(other.presses_.load(std::memory_order_acquire)),
        presses_cleared_(other.presses_cleared_),
        homed_(other.homed_),
        enabled_(other.enabled_) {}
  /// Owner of the device only. Clears the emergency stops pressed before the call and leaves the
  /// forces disabled: a reset must not start motion (ISO 13850).
  void Home() noexcept {
    homed_ = true;
    enabled_ = false;
    presses_cleared_ = presses_.load(std::memory_order_acquire);
  }
  /// Owner of the device only.
  void Enable(bool on) noexcept { enabled_ = on; }
  /// Any thread or signal handler; wait-free.
  void EmergencyStop() noexcept { presses_.fetch_add(1, std::memory_order_release); }
  /// Owner of the device only; wait-free.
  bool On() const noexcept {
    return homed_ && enabled_ && presses_.load(std::memory_order_acquire) == presses_cleared_;
  }

 private:
  static_assert(std::atomic<std::uint32_t>::is_always_lock_free);
  std::atomic<std::uint32_t> presses_ = 0;
  std::uint32_t presses_cleared_ = 0;
  bool homed_ = false;
  bool enabled_ = false;
};

/// One laparoscopic haptic device: five tracked axes (JointVector), three actuated (AxisEffort).
///
/// The device has one owner at a time: the haptic thread while the haptic loop runs, the main
/// thread before and after. Other threads may call only EmergencyStop.
class Device {
 public:
  virtual ~Device() = default;

  /// Returns a copy that continues from the same state to the last bit; nullptr for a device whose
  /// state is outside of the program. Allocates.
  virtual std::unique_ptr<Device> Clone() const { return nullptr; }

  /// Returns the pose at session time `now`. Without a usable answer, `valid` is false and the pose
  /// is the last one. Owner; wait-free, no allocation.
  virtual DeviceSample Read(Nanoseconds now) noexcept = 0;

  /// Displays efforts until the next Write: pitch (N m), yaw (N m), insertion (N). An axis beyond
  /// its limit saturates; a value that is not finite counts as 0. Nothing is displayed while
  /// ForceOn() is false. Owner; wait-free, no allocation.
  virtual void Write(const AxisEffort& effort) noexcept = 0;

  /// Finds the axes' zero positions and clears an emergency stop. Forces stay off until
  /// EnableForce(true). Owner, outside the loop. Throws MachineError if the device does not answer.
  virtual void Home() = 0;

  /// Enables or disables the forces. Disabling removes the force at once. Owner; wait-free.
  virtual void EnableForce(bool on) noexcept = 0;

  /// Removes the force at once and latches until Home. Any thread or signal handler; wait-free.
  virtual void EmergencyStop() noexcept = 0;

  /// True if homed, enabled and not stopped. Owner; wait-free.
  virtual bool ForceOn() const noexcept = 0;

  virtual DeviceLimits limits() const noexcept = 0;
};

}  // namespace hpdm
