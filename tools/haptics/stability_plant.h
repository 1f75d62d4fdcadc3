#pragma once

#include <array>

#include "haptics/device/impulse_engine.h"
#include "haptics/safety/stability.h"

namespace hpdm {

struct StabilityPlantOptions {
  AxisDynamics axis;        ///< With the hand's damping and spring where one holds it.
  double friction = 0;      ///< N, Coulomb.
  double encoder_step = 0;  ///< m; 0: continuous.
  double push = 1;          ///< N, constant, into the tissue.
  Nanoseconds period_ns = 1'000'000;
  Nanoseconds delay_ns = 0;  ///< Age of the samples when they are read; below 100 periods.
};

/// A device of which only the insertion axis moves, integrated exactly, for measurements of
/// stability: an integrator that damps on its own (SimDevice's does) would move their result.
///
///     m x'' = tau + push - b x' - k x - f_c sign(x')
///
/// with x the insertion from its start, tau the written effort, held from Read to Read. Between the
/// changes of tau and of the direction of motion the solution is the closed form of ExactStep();
/// where the velocity comes to zero the axis stops, and goes on when the other forces exceed the
/// friction. The encoder rounds what is read, not what moves.
///
/// Reads must come one period apart: the sample that a Read returns was taken delay_ns before.
class StabilityPlant : public Device {
 public:
  StabilityPlant(const StabilityPlantOptions& options, double insertion);

  DeviceSample Read(Nanoseconds now) noexcept override;
  void Write(const AxisEffort& effort) noexcept override { effort_ = effort[kInsertion]; }
  void Home() noexcept override { force_.Home(); }
  void EnableForce(bool on) noexcept override { force_.Enable(on); }
  void EmergencyStop() noexcept override { force_.EmergencyStop(); }
  bool ForceOn() const noexcept override { return force_.On(); }
  DeviceLimits limits() const noexcept override { return LimitsOf({}); }

  /// Until then the axis stands still, whatever is written.
  void Release(double velocity) noexcept {
    held_ = false;
    v_ = velocity;
  }
  double x() const { return x_; }  ///< m, from the start.
  double v() const { return v_; }  ///< m/s.
  /// J, about the start: of the motion, and of the hand's spring and one of `stiffness` (N/m).
  double axis_energy(double stiffness) const {
    return 0.5 * (options_.axis.mass * v_ * v_ + (options_.axis.stiffness + stiffness) * x_ * x_);
  }

  /// The true motion over a time (s) under the effort that is written.
  void Advance(double t) noexcept;

 private:
  static constexpr int kMaxDelay = 128;  // samples

  StabilityPlantOptions options_;
  double insertion_;
  double early_ = 0, late_ = 0;  // s: a period before and after the moment that a sample is of
  int delay_ = 0;                // that many Reads later it is read
  HeldForceStep early_step_, late_step_;
  ForceSwitch force_;
  double effort_ = 0;
  double x_ = 0, v_ = 0;
  bool held_ = true;
  std::array<double, kMaxDelay> taken_ = {};
  std::uint64_t reads_ = 0;
};

}  // namespace hpdm
