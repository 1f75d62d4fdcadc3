#include "haptics/safety/passivity.h"

#include <algorithm>
#include <cmath>

namespace hpdm {

PassivityControl::PassivityControl(const PassivityOptions& options)
    : options_(options),
      window_ns_(std::llround(options.window * 1e9)),
      account_(Vector3d::Constant(options.reserve)) {}

Vector3d PassivityControl::Damp(Nanoseconds now, const DeviceSample& sample,
                                const Vector3d& p_tip_W, const Matrix3d& J,
                                const Vector3d& reaction_W) noexcept {
  now_ns_ = now;
  sample_ = sample;
  p_tip_W_ = p_tip_W;
  J_ = J;
  reaction_W_ = reaction_W;
  damping_ = 0;
  MeasureVelocity();
  const bool touches = reaction_W.squaredNorm() > 0;  // false for NaN
  if (!options_.control || !touches || !sample.valid) return Vector3d::Zero();

  const double age = std::max(0.0, ToSeconds(now - sample.time_ns));
  const double lag = 0.5 * (span_ + options_.period) + age;
  Vector3d force_W = Vector3d::Zero();
  for (int i = 0; i < 3; ++i) {
    const double owed = -account_[i], v = velocity_[i];
    const double g = J.col(i).squaredNorm();
    if (!(owed > 0) || !(g > 0)) continue;
    double full = 0.5 * options_.device.inertia[i] / lag;
    const double step = options_.device.encoder_step[i];
    if (step > 0) full = std::min(full, options_.ripple * std::sqrt(g) * options_.window / step);
    // Dissipates at most the debt within `pay`: damping v^2 pay <= owed.
    const double damping =
        std::min(std::min(owed / options_.full, 1.0) * full, owed / (v * v * options_.pay));
    // The columns of J are orthogonal, so a force with effort tau on this axis and none on the
    // others lies along this axis' column.
    force_W -= damping * v / g * J.col(i);
    damping_ = std::max(damping_, damping / g);
  }
  return force_W;
}

void PassivityControl::Observe(const Vector3d& force_W, double authority, bool force_on) noexcept {
  const AxisEffort effort = J_.transpose() * force_W;
  if (!force_on) {
    account_.setConstant(options_.reserve);
    energy_ = 0;
    damping_ = 0;
    judged_.valid = false;
  } else if (sample_.valid) {
    // The guard replaces a reaction that is not finite; its displayed force counts as the request.
    const Vector3d asked_W = reaction_W_.allFinite() ? Vector3d(authority * reaction_W_) : force_W;
    const Judged before = judged_;
    judged_ = {true, sample_.time_ns, sample_.joints.head<3>(), p_tip_W_, J_.transpose() * asked_W};
    if (before.valid && judged_.sample_ns > before.sample_ns) Settle(before);
  }
  newest_ = (newest_ + 1) % kHistory;
  count_ = std::min(count_ + 1, kHistory);
  history_[newest_] = {now_ns_, sample_.time_ns, sample_.joints.head<3>(), force_W, effort};
}

// Settles the motion from `before` to the newest sample on the accounts.
void PassivityControl::Settle(const Judged& before) {
  const Held held = HeldBetween(before.sample_ns, judged_.sample_ns);
  if (!held.known) return;
  energy_ -= held.force_W.dot(judged_.p_tip_W - before.p_tip_W);

  const double dt = ToSeconds(judged_.sample_ns - before.sample_ns);
  const double kept = std::exp(-dt / options_.leak);
  const Vector3d dq = judged_.q - before.q;
  for (int i = 0; i < 3; ++i) {
    const double asked = 0.5 * (before.asked[i] + judged_.asked[i]);
    const double generated = (held.effort[i] - asked) * dq[i];
    // Damping consumes least at constant velocity. For a motion of less than a count only its mean
    // over the window is known.
    const double moved = std::max(0.0, std::abs(dq[i]) - options_.device.encoder_step[i]);
    const double velocity = std::max(std::abs(velocity_[i]), moved / dt);
    const double consumed =
        options_.device_share * (options_.device.damping[i] * velocity * velocity * dt +
                                 options_.device.friction[i] * std::abs(dq[i]));
    const double balance = account_[i] + consumed - generated;
    account_[i] = std::clamp(options_.reserve + kept * (balance - options_.reserve), -options_.debt,
                             options_.reserve);
  }
}

PassivityControl::Held PassivityControl::HeldBetween(Nanoseconds from_ns, Nanoseconds to_ns) const {
  Held held;
  Nanoseconds until = to_ns;
  for (int back = 0; back < count_; ++back) {
    const Tick& tick = Back(back);
    const Nanoseconds since = std::max(tick.written_ns, from_ns);
    if (since < until) {
      const double part = ToSeconds(until - since) / ToSeconds(to_ns - from_ns);
      held.force_W += part * tick.force_W;
      held.effort += part * tick.effort;
      until = since;
    }
    if (until <= from_ns) {
      held.known = true;
      break;
    }
  }
  return held;
}

// Measures from the newest sample that is at least the window older than the present one.
void PassivityControl::MeasureVelocity() {
  velocity_.setZero();
  span_ = options_.window;
  if (!sample_.valid) return;
  for (int back = 0; back < count_; ++back) {
    const Tick& tick = Back(back);
    const Nanoseconds dt = sample_.time_ns - tick.sample_ns;
    if (dt < window_ns_ && back + 1 < count_) continue;
    if (dt <= 0) return;
    span_ = ToSeconds(dt);
    velocity_ = (sample_.joints.head<3>() - tick.q) / span_;
    return;
  }
}

}  // namespace hpdm
