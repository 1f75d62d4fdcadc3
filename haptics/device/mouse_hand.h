#pragma once

#include "engine/threads/triple_buffer.h"
#include "haptics/device/hand.h"

namespace hpdm {

/// Where a mouse wants an instrument: window -> haptic loop, latest value, one triple buffer an
/// instrument.
struct HandTarget {
  Vector3d p_W = Vector3d::Zero();  ///< Of the tip's centre, m.
  double roll = 0;                  ///< rad.
  double jaw = 1;                   ///< 0 closed .. 1 open.
};

/// A hand that goes where a mouse wants it, for people who own no device.
///
///     window --HandTarget, latest--> [MouseHand] -> SimDevice <-> haptic loop
///
/// A mouse speaks 60 to 125 times a second and in whole pixels: taken as it comes, the tip would
/// jump by half a millimetre and the force with it. Each coordinate u of the target is followed by
///
///     x'' = w^2 (u - x) - 2 w x',   w = 2 pi kBandwidth,
///
/// a critically damped spring, integrated exactly between two looks at the target: position and
/// velocity are continuous, and a target that stops is reached without going past it.
class MouseHand : public Hand {
 public:
  /// Hz. The hand lags a steady motion by 2 / w = 40 ms, which the eye forgives in a mouse, and
  /// lets through 2 % of the steps of a 60 Hz mouse: 1 / (1 + (60 / 8)^2).
  static constexpr double kBandwidth = 8;

  /// Starts at rest at `start`; impedance as in Hand.
  MouseHand(const HandTarget& start, double stiffness, double damping);

  /// Where the window writes. One writer.
  TripleBuffer<HandTarget>& targets() { return targets_; }

  HandIntent At(Nanoseconds t_ns) noexcept override;

 private:
  using Coordinates = Eigen::Matrix<double, 5, 1>;  // x, y, z (m), roll (rad), jaw
  static Coordinates CoordinatesOf(const HandTarget& target);

  TripleBuffer<HandTarget> targets_;
  Coordinates position_;
  Coordinates velocity_ = Coordinates::Zero();
  Nanoseconds last_ns_ = 0;
};

}  // namespace hpdm
