#pragma once

#include "engine/threads/triple_buffer.h"
#include "haptics/device/hand.h"

namespace hpdm {

/// Target of an instrument from a mouse: window -> haptic loop, latest value, one triple buffer per
/// instrument.
struct HandTarget {
  Vector3d p_W = Vector3d::Zero();  ///< Tip's centre, m.
  double roll = 0;                  ///< rad.
  double jaw = 1;                   ///< 0 closed .. 1 open.
};

/// A hand that follows a mouse, for use without a device.
///
///     window --HandTarget, latest--> [MouseHand] -> SimDevice <-> haptic loop
///
/// A mouse reports 60 to 125 times per second, in whole pixels. Unfiltered, the tip would jump by
/// half a millimetre, and the force with it. Each coordinate u of the target is followed by a
/// critically damped spring,
///
///     x'' = w^2 (u - x) - 2 w x',   w = 2 pi kBandwidth,
///
/// integrated exactly between two readings of the target. Position and velocity are continuous, and
/// the hand reaches a fixed target without overshoot.
class MouseHand : public Hand {
 public:
  /// Hz. The hand lags a steady motion by 2 / w = 40 ms, which is acceptable for a mouse. It passes
  /// 1 / (1 + (60 / 8)^2) = 2 % of the steps of a 60 Hz mouse.
  static constexpr double kBandwidth = 8;

  /// Starts at rest at `start`; impedance as in Hand.
  MouseHand(const HandTarget& start, double stiffness, double damping);

  /// The buffer for the window's targets. One writer.
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
