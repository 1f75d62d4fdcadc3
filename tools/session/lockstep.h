#pragma once

#include <cstdint>
#include <deque>

#include "engine/deformation_loop.h"
#include "haptics/haptic_loop.h"
#include "scenes/loader/scene.h"

namespace hpdm {

/// The lockstep clock of a haptic and a deformation loop: one thread, virtual time.
///
/// Step j takes the tool state of tick ceil(j haptic_hz / deformation_hz). Its patch becomes
/// visible patch_delay_ticks later. The step is computed only then, from the state saved at its
/// start; the result is the same.
///
///     while (...) { clock.StepIfDue(); clock.Tick(); }
///     clock.RampOut();  // where a device displays the force
class Lockstep {
 public:
  /// Both loops must outlive this.
  Lockstep(const TimingOptions& timing, HapticLoop* haptics, DeformationLoop* deformation)
      : timing_(timing), haptics_(haptics), deformation_(deformation) {}

  /// Gives a copy loops of its own, which hold copies of the original's states.
  void Attach(HapticLoop* haptics, DeformationLoop* deformation) {
    haptics_ = haptics;
    deformation_ = deformation;
  }

  /// Returns the number of the next tick.
  std::uint64_t tick() const { return tick_; }

  /// Returns the tick in which step number `step` (from 0) begins.
  std::uint64_t BeginOf(std::uint64_t step) const {
    return (step * timing_.haptic_hz + timing_.deformation_hz - 1) / timing_.deformation_hz;
  }

  /// Computes the step whose patch first becomes visible to the next tick. True if there was one.
  bool StepIfDue();

  /// Runs a haptic tick and begins the step that takes its tool state, if any.
  void Tick();

  /// Takes the forces away after the last tick (HapticLoop::RampOut).
  void RampOut();

 private:
  Nanoseconds ScheduledAt(std::uint64_t tick) const;

  TimingOptions timing_;
  HapticLoop* haptics_;
  DeformationLoop* deformation_;
  std::uint64_t tick_ = 0;
  std::uint64_t steps_begun_ = 0;
  std::deque<ToolState> begun_;
};

}  // namespace hpdm
