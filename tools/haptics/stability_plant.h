#pragma once

#include <array>

#include "haptics/device/impulse_engine.h"
#include "haptics/device/switched_device.h"
#include "haptics/safety/stability.h"

namespace hpdm {

struct StabilityPlantOptions {
  AxisDynamics axis;  ///< Along the guide; includes the hand's damping and spring if one holds it.
  double friction = 0;                       ///< N, Coulomb.
  double push = 1;                           ///< N, constant, into the tissue.
  Vector3d encoder_step = Vector3d::Zero();  ///< Of pitch, yaw (rad), insertion (m); 0: continuous.
  /// Motion of pitch, yaw (rad/m) and insertion (m/m) per metre along the guide.
  Vector3d guide = Vector3d::UnitZ();
  Nanoseconds period_ns = 1'000'000;
  Nanoseconds delay_ns = 0;  ///< Age of the samples when they are read; below 100 periods.
};

/// A device whose tip moves only along a guide, integrated exactly, for measurements of stability
/// and transparency. An integrator with damping of its own, as SimDevice has, would change the
/// result.
///
///    m x'' = tau + push - b x' - k x - f_c sign(x')
///
/// x is the way from its start; the joints are start + guide x, and tau = guide . effort, with the
/// written effort held from Read to Read. Between changes of tau and of the direction of motion,
/// ExactStep() gives the solution in closed form. At zero velocity the tip stops until the other
/// forces exceed the friction. The encoders round the reading, not the motion.
///
/// Reads must come one period apart: a Read returns the sample taken delay_ns before.
class StabilityPlant : public SwitchedDevice {
 public:
  StabilityPlant(const StabilityPlantOptions& options, const JointVector& start);

  DeviceSample Read(Nanoseconds now) noexcept override;
  void Write(const AxisEffort& effort) noexcept override { effort_ = options_.guide.dot(effort); }
  DeviceLimits limits() const noexcept override { return LimitsOf({}); }

  /// Moves the tip to x (m) until it is released, whatever is written.
  void Hold(double x) noexcept { x_ = x; }
  /// Starts the motion with a velocity (m/s).
  void Release(double velocity) noexcept {
    held_ = false;
    v_ = velocity;
  }
  /// Sets the push (N).
  void Push(double push) noexcept { options_.push = push; }
  void SetJaw(double jaw) noexcept { start_[kJaw] = jaw; }
  double x() const { return x_; }                             ///< m, from the start.
  double v() const { return v_; }                             ///< m/s.
  double force() const { return force_.On() ? effort_ : 0; }  ///< N along the guide, displayed.
  /// Energy about the start, J: kinetic, plus the springs of the hand and of `stiffness` (N/m).
  double Energy(double stiffness) const {
    return 0.5 * (options_.axis.mass * v_ * v_ + (options_.axis.stiffness + stiffness) * x_ * x_);
  }

  /// Advances the true motion by t (s) under the written effort.
  void Advance(double t) noexcept;

 private:
  static constexpr int kMaxDelay = 128;  // samples

  StabilityPlantOptions options_;
  JointVector start_;
  double early_ = 0, late_ = 0;  // s: parts of a period before and after a sample's moment
  int delay_ = 0;                // Reads from the sample to its delivery
  HeldForceStep early_step_, late_step_;
  double effort_ = 0;
  double x_ = 0, v_ = 0;
  bool held_ = true;
  std::array<double, kMaxDelay> taken_ = {};
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
