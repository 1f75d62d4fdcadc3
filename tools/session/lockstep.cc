#include "tools/session/lockstep.h"

namespace hpdm {

bool Lockstep::StepIfDue() {
  if (begun_.empty() || tick_ != begun_.front().tick + timing_.patch_delay_ticks) return false;
  deformation_->Step(begun_.front(), begun_.front().time_ns);
  begun_.pop_front();
  return true;
}

void Lockstep::Tick() {
  const Nanoseconds period = kNanosecondsPerSecond / timing_.haptic_hz;
  haptics_->Tick(tick_, static_cast<Nanoseconds>(tick_) * period, {});
  const std::uint64_t begins =
      (steps_begun_ * timing_.haptic_hz + timing_.deformation_hz - 1) / timing_.deformation_hz;
  if (tick_ == begins) {
    begun_.push_back(deformation_->NewestTools());
    ++steps_begun_;
  }
  ++tick_;
}

}  // namespace hpdm
