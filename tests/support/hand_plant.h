#pragma once

#include <array>
#include <cmath>
#include <functional>

#include "haptics/device/device_axes.h"
#include "haptics/device/impulse_engine.h"
#include "haptics/device/switched_device.h"

/// A device in a hand, integrated apart from the engine's own simulations.
namespace hpdm {

// The hand's spring and damper from the tip to the place that it intends.
struct HandGrip {
  double stiffness = 0;  // N/m
  double damping = 0;    // N s/m
  Vector3d p_W = Vector3d::Zero();
  Vector3d v_W = Vector3d::Zero();
};

// Pitch, yaw and insertion with their inertia, damping, Coulomb friction and encoders, in steps of
// 10 us. The Jacobian is that of the start: motions are small. A sample is `delay` old when it is
// read. Read it every period.
class HandPlant : public SwitchedDevice {
 public:
  using Hand = std::function<HandGrip(double t)>;

  HandPlant(const DeviceProfile& profile, const ImpulseEngineKinematics& kinematics,
            const Vector3d& p_start_W, const Vector3d& v_start_W, Hand hand)
      : axes_(AxesOf(profile)),
        delay_steps_(static_cast<int>(std::lround(profile.delay / kStep))),
        p_start_W_(p_start_W),
        start_(kinematics.Inverse(p_start_W, 0, 1).joints),
        J_(kinematics.Jacobian(start_)),
        hand_(std::move(hand)) {
    q_ = start_.head<3>();
    v_ = J_.inverse() * v_start_W;
    past_.fill(q_);
  }

  DeviceSample Read(Nanoseconds now) noexcept override {
    if (reads_ > 0) {
      for (int i = 0; i < kSteps; ++i) Advance();
    }
    DeviceSample sample{.sequence = ++reads_, .valid = true};
    sample.time_ns = now - static_cast<Nanoseconds>(delay_steps_) * 10'000;
    sample.joints = start_;
    const Vector3d& q = past_[(steps_ + kKept - delay_steps_) % kKept];
    for (int i = 0; i < 3; ++i) {
      const double step = axes_.encoder_step[i];
      sample.joints[i] = step > 0 ? std::round(q[i] / step) * step : q[i];
    }
    return sample;
  }
  void Write(const AxisEffort& effort) noexcept override { effort_ = effort; }
  DeviceLimits limits() const noexcept override { return LimitsOf({}); }

  const Vector3d& q() const { return q_; }
  Vector3d p_W() const { return p_start_W_ + J_ * (q_ - start_.head<3>()); }
  Vector3d force_W() const { return J_.transpose().inverse() * effort_; }
  double time() const { return steps_ * kStep; }
  // Energy that the motors gave to device and hand beyond what the device dissipated, J.
  double given() const { return work_ - dissipated_; }

 private:
  static constexpr double kStep = 1e-5;  // s
  static constexpr int kSteps = 100;     // a read
  static constexpr int kKept = 2048;

  void Advance() {
    const HandGrip grip = hand_(time());
    const Vector3d pull_W = grip.stiffness * (grip.p_W - p_W()) + grip.damping * grip.v_W;
    const Vector3d effort = force_.On() ? effort_ : Vector3d::Zero();
    for (int i = 0; i < 3; ++i) {
      const double g = J_.col(i).squaredNorm();
      const double momentum =
          axes_.inertia[i] * v_[i] + kStep * (J_.col(i).dot(pull_W) + effort[i]);
      const double held = kStep * axes_.friction[i];
      const double left = std::copysign(std::max(std::abs(momentum) - held, 0.0), momentum);
      v_[i] = left / (axes_.inertia[i] + kStep * (axes_.damping[i] + grip.damping * g) +
                      kStep * kStep * grip.stiffness * g);
      const double dq = kStep * v_[i];
      q_[i] += dq;
      work_ += effort[i] * dq;
      dissipated_ += axes_.damping[i] * v_[i] * dq + axes_.friction[i] * std::abs(dq);
    }
    past_[++steps_ % kKept] = q_;
  }

  DeviceAxes axes_;
  int delay_steps_;
  Vector3d p_start_W_;
  JointVector start_;
  Matrix3d J_;
  Hand hand_;
  AxisEffort effort_ = AxisEffort::Zero();
  Vector3d q_, v_;
  std::array<Vector3d, kKept> past_;
  int steps_ = 0;
  std::uint64_t reads_ = 0;
  double work_ = 0, dissipated_ = 0;
};

}  // namespace hpdm
