#include "haptics/contact/trocar_friction.h"

#include <algorithm>
#include <cmath>

#include "haptics/safety/stability.h"

namespace hpdm {

TrocarFriction::TrocarFriction(const TrocarFrictionOptions& options,
                               const PassivityOptions& passivity)
    : options_(options) {
  const DeviceAxes& axes = passivity.device;
  const auto half = [&](int axis) {
    return 0.5 * PassivityBound(axes.damping[axis], axes.friction[axis], axes.encoder_step[axis],
                                passivity.period, options.delay);
  };
  pivot_stiffness_ = options.torque > 0 ? std::min(half(0), half(1)) : 0;
  shaft_stiffness_ = options.force > 0 ? half(2) : 0;
}

AxisEffort TrocarFriction::Effort(const Vector3d& q) noexcept {
  if (!started_) dragged_ = q;
  started_ = true;
  Vector3d stretch = q - dragged_;
  AxisEffort effort;
  effort.head<2>() = -pivot_stiffness_ * stretch.head<2>();
  effort[2] = -shaft_stiffness_ * stretch[2];
  const double turning = effort.head<2>().norm(), pulling = std::abs(effort[2]);
  if (turning > options_.torque) {
    effort.head<2>() *= options_.torque / turning;
    stretch.head<2>() *= options_.torque / turning;
  }
  if (pulling > options_.force) {
    effort[2] *= options_.force / pulling;
    stretch[2] *= options_.force / pulling;
  }
  dragged_ = q - stretch;
  return effort;
}

}  // namespace hpdm
