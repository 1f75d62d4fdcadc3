#include "haptics/safety/passivity.h"

#include <algorithm>
#include <cmath>

namespace hpdm {

double FullDamping(const PassivityOptions& options, int axis, double arm, double span, double age) {
  const double full = 0.5 * options.device.inertia[axis] / (0.5 * (span + options.period) + age);
  const double step = options.device.encoder_step[axis];
  return step > 0 ? std::min(full, options.ripple * arm * options.window / step) : full;
}

PassivityControl::PassivityControl(const PassivityOptions& options)
    : options_(options),
      window_ns_(std::llround(options.window * 1e9)),
      account_(Vector3d::Constant(options.reserve)) {}

Vector3d PassivityControl::Damp(Nanoseconds now, const DeviceSample& sample,
                                const Vector3d& p_tip_W, const Matrix3d& J,
                                const Vector3d& reaction_W, const WallPress& wall,
                                const Vector3d& friction_W) noexcept {
  now_ns_ = now;
  sample_ = sample;
  p_tip_W_ = p_tip_W;
  J_ = J;
  reaction_W_ = reaction_W;
  damping_ = 0;
  MeasureVelocity();
  const bool touches = reaction_W.squaredNorm() > 0;  // false for NaN
  if (!touches || !(wall.stored > 0)) wall_.presses = false;
  Vector3d force_W = Vector3d::Zero();
  if (friction_W.squaredNorm() > 0) {
    force_W = friction_W;
    reaction_W_ += friction_W;
  }
  if (!options_.control || !touches || !sample.valid) return force_W;

  if (wall.stored > 0) {
    SettleWall(wall);
    const Vector3d less_W = (WallShare(wall) - 1) * wall.reaction_W;
    reaction_W_ += less_W;
    force_W += less_W;
  }
  const double age = Age();
  for (int i = 0; i < 3; ++i) {
    const double owed = -account_[i], v = velocity_[i];
    const double g = J.col(i).squaredNorm();
    if (!(owed > 0) || !(g > 0)) continue;
    const double full = FullDamping(options_, i, std::sqrt(g), span_, age);
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
  authority_ = authority;
  if (!force_on) {
    account_.setConstant(options_.reserve);
    energy_ = 0;
    damping_ = 0;
    judged_.valid = false;
    wall_.presses = false;
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
    const double balance = account_[i] + Consumed(i, dq[i], dt) - generated;
    account_[i] = std::clamp(options_.reserve + kept * (balance - options_.reserve), -options_.debt,
                             options_.reserve);
  }
}

// Adds the hand's work on the wall from the wall's last sample to the newest one.
void PassivityControl::SettleWall(const WallPress& wall) {
  const Vector3d q = sample_.joints.head<3>();
  const Vector3d soft_W = reaction_W_ - wall.reaction_W;
  const Wall before = wall_;
  if (!before.presses) {
    wall_ = {true,   sample_.time_ns, q, wall.p_tip_organ_W, Vector3d::Zero(),
             soft_W, options_.reserve};
  } else if (sample_.time_ns > before.sample_ns) {
    const double dt = ToSeconds(sample_.time_ns - before.sample_ns);
    const Vector3d moved_W = wall.p_tip_organ_W - before.p_tip_organ_W;
    const Held held = HeldBetween(before.sample_ns, sample_.time_ns);
    const Vector3d soft_held_W = authority_ / 2 * (before.soft_W + soft_W);
    double energy = before.energy - (held.force_W - soft_held_W).dot(moved_W);
    for (int i = 0; i < 3; ++i) energy += Consumed(i, q[i] - before.q[i], dt);
    wall_ = {true, sample_.time_ns, q, wall.p_tip_organ_W, moved_W / dt, soft_W, energy};
  }
  wall_.energy = std::clamp(wall_.energy, -options_.debt, wall.stored + options_.reserve);
}

// Returns the fraction of the wall's reaction that its energy covers.
double PassivityControl::WallShare(const WallPress& wall) const {
  const double force = wall.reaction_W.norm();
  if (!(force > 0)) return 1;  // two walls in balance
  const Vector3d out_W = wall.reaction_W / force;
  // A single count is not taken for a motion.
  const Vector3d turn = (J_.transpose() * out_W).cwiseAbs();
  const double count = turn.dot(options_.device.encoder_step) / options_.period;
  const double speed = std::max(0.0, wall_.v_W.dot(out_W) - count);
  double stiffness = force * force / (2 * wall.stored);
  if (speed > 0) stiffness = std::min(stiffness, options_.max_force_rate / speed);
  const double most = std::sqrt(2 * std::max(wall_.energy, 0.0) * stiffness) -
                      stiffness * speed * (options_.period + Age());
  return std::clamp(most / force, 0.0, 1.0);
}

double PassivityControl::Age() const { return std::max(0.0, ToSeconds(now_ns_ - sample_.time_ns)); }

// Damping consumes least at constant velocity. For a motion of less than a count only its mean over
// the window is known.
double PassivityControl::Consumed(int axis, double dq, double dt) const {
  const double moved = std::max(0.0, std::abs(dq) - options_.device.encoder_step[axis]);
  const double velocity = std::max(std::abs(velocity_[axis]), moved / dt);
  return options_.device_share * (options_.device.damping[axis] * velocity * velocity * dt +
                                  options_.device.friction[axis] * std::abs(dq));
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
