#include "tools/session/lockstep.h"

namespace hpdm {

bool Lockstep::StepIfDue() {
  if (begun_.empty() || tick_ != begun_.front().tick + timing_.patch_delay_ticks) return false;
  deformation_->Step(begun_.front(), begun_.front().time_ns);
  begun_.pop_front();
  return true;
}

void Lockstep::Tick() {
  haptics_->Tick(tick_, ScheduledAt(tick_), {});
  if (tick_ == BeginOf(steps_begun_)) {
    begun_.push_back(deformation_->NewestTools());
    ++steps_begun_;
  }
  ++tick_;
}

void Lockstep::RampOut() {
  std::uint64_t tick = tick_;
  for (std::uint64_t left = haptics_->RampOutTicks(); left-- > 0; ++tick) {
    haptics_->RampOut(tick, ScheduledAt(tick), {}, left);
  }
}

Nanoseconds Lockstep::ScheduledAt(std::uint64_t tick) const {
  return static_cast<Nanoseconds>(tick) * (kNanosecondsPerSecond / timing_.haptic_hz);
}

}  // namespace hpdm
