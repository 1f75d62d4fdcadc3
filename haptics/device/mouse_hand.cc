#include "haptics/device/mouse_hand.h"

#include <cmath>
#include <numbers>

namespace hpdm {

MouseHand::MouseHand(const HandTarget& start, double stiffness, double damping)
    : Hand(stiffness, damping), targets_(start), position_(CoordinatesOf(start)) {}

MouseHand::Coordinates MouseHand::CoordinatesOf(const HandTarget& target) {
  Coordinates coordinates;
  coordinates << target.p_W, target.roll, target.jaw;
  return coordinates;
}

HandIntent MouseHand::At(Nanoseconds t_ns) noexcept {
  targets_.Update();
  const Coordinates target = CoordinatesOf(targets_.Front());
  const double h = ToSeconds(t_ns - last_ns_);
  last_ns_ = t_ns;
  // With x = u + (a + b t) exp(-w t): a = x - u, b = x' + w a.
  constexpr double w = 2 * std::numbers::pi * kBandwidth;
  const double decay = std::exp(-w * h);
  const Coordinates a = position_ - target;
  const Coordinates b = velocity_ + w * a;
  position_ = target + decay * (a + h * b);
  velocity_ = decay * (b - w * (a + h * b));

  HandIntent intent;
  intent.p_W = position_.head<3>();
  intent.v_W = velocity_.head<3>();
  intent.roll = position_[3];
  intent.jaw = position_[4];
  return intent;
}

}  // namespace hpdm
