#include "tools/haptics/stability_plant.h"

#include <cmath>

#include "engine/base/check.h"

namespace hpdm {
namespace {

void Apply(const HeldForceStep& step, double force, double* x, double* v) {
  const Eigen::Vector2d next = step.transition * Eigen::Vector2d(*x, *v) + step.input * force;
  *x = next[0];
  *v = next[1];
}

}  // namespace

StabilityPlant::StabilityPlant(const StabilityPlantOptions& options, const JointVector& start)
    : options_(options), start_(start) {
  delay_ = static_cast<int>((options.delay_ns + options.period_ns - 1) / options.period_ns);
  HPDM_CHECK(delay_ < kMaxDelay);
  late_ = ToSeconds(options.delay_ns - (delay_ - 1) * options.period_ns);
  if (delay_ == 0) late_ = 0;
  early_ = ToSeconds(options.period_ns) - late_;
  early_step_ = ExactStep(options.axis, early_);
  late_step_ = ExactStep(options.axis, late_);
}

// A sample taken `early` s into a period between two Reads is delivered `delay_` Reads after the
// start of that period. Its age is delay_ periods minus `early`, or delay_ - 1 periods plus `late`.
DeviceSample StabilityPlant::Read(Nanoseconds now) noexcept {
  const auto slot = [this](std::uint64_t n) -> double& { return taken_[n % kMaxDelay]; };
  if (reads_ > 0 && !held_) {
    Advance(early_);
    slot(reads_) = x_;
    if (late_ > 0) Advance(late_);
  } else {
    slot(reads_) = x_;
  }
  // The period that ended `delay_ - 1` Reads ago contains the sample's moment.
  const std::uint64_t back = delay_ > 0 ? delay_ - 1 : 0;
  const double x = reads_ >= back ? slot(reads_ - back) : 0;
  ++reads_;
  DeviceSample sample{.sequence = reads_, .time_ns = now - options_.delay_ns, .valid = true};
  sample.joints = start_;
  for (int i = 0; i < 3; ++i) {
    const double q = start_[i] + options_.guide[i] * x, step = options_.encoder_step[i];
    sample.joints[i] = step > 0 ? std::round(q / step) * step : q;
  }
  return sample;
}

void StabilityPlant::Advance(double t) noexcept {
  const double force = this->force() + options_.push;
  const double friction = options_.friction, k = options_.axis.stiffness;
  const auto step_of = [this](double time) {
    return time == early_  ? early_step_
           : time == late_ ? late_step_
                           : ExactStep(options_.axis, time);
  };
  if (friction == 0) {
    Apply(step_of(t), force, &x_, &v_);
    return;
  }
  // Usually a period has no stop, rarely more than one. Eight stops would be a vibration that
  // friction has long damped.
  for (int i = 0; i < 8 && t > 0; ++i) {
    if (v_ == 0 && std::abs(force - k * x_) <= friction) return;
    const double sign = std::copysign(1.0, v_ != 0 ? v_ : force - k * x_);
    double x = x_, v = v_;
    Apply(step_of(t), force - sign * friction, &x, &v);
    if (sign * v > 0) {
      x_ = x;
      v_ = v;
      return;
    }
    double moving = 0, stopped = t;  // bracket the time of zero velocity
    while (stopped - moving > 1e-9 * t) {
      const double middle = 0.5 * (moving + stopped);
      x = x_;
      v = v_;
      Apply(ExactStep(options_.axis, middle), force - sign * friction, &x, &v);
      (sign * v > 0 ? moving : stopped) = middle;
    }
    x_ = x;
    v_ = 0;
    t -= stopped;
  }
}

}  // namespace hpdm
