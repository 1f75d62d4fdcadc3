#include "haptics/safety/wall_limit.h"

#include <cmath>
#include <limits>

#include "engine/base/check.h"
#include "haptics/safety/stability.h"

namespace hpdm {
namespace {

constexpr int kLevers = 17;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

WallLimits::WallLimits(const PassivityOptions& passivity, double delay, double shortest,
                       double longest)
    : device_(passivity.device), shortest_(shortest), longest_(longest) {
  HPDM_CHECK(shortest > 0 && longest >= shortest);
  const int window = std::max(1, static_cast<int>(std::ceil(passivity.window / passivity.period)));
  const double span = window * passivity.period;
  const auto limit = [&](int axis, double arm) {
    SampledDamper damper{.damping = 0, .window = window};
    if (passivity.control) damper.damping = FullDamping(passivity, axis, arm, span, delay);
    return StabilityLimit({device_.inertia[axis], device_.damping[axis]}, passivity.period, delay,
                          damper);
  };
  for (int i = 0; i < kLevers; ++i) {
    const double arm = shortest + (longest - shortest) * i / (kLevers - 1);
    // Pitch and yaw may be the same; a limit takes 10 ms.
    stability_[0].push_back(limit(0, arm));
    const bool same = device_.inertia[0] == device_.inertia[1] &&
                      device_.damping[0] == device_.damping[1] &&
                      device_.encoder_step[0] == device_.encoder_step[1];
    stability_[1].push_back(same ? stability_[0].back() : limit(1, arm));
  }
  stability_[2].push_back(limit(2, 1));  // insertion: the tip moves as far as the axis
}

double WallLimits::AxisStability(int axis, double arm) const {
  const std::vector<double>& table = stability_[static_cast<std::size_t>(axis)];
  const double last = static_cast<double>(table.size() - 1);
  if (last == 0 || longest_ == shortest_) return table.front();
  const double at = std::clamp((arm - shortest_) / (longest_ - shortest_) * last, 0.0, last);
  const auto i = std::min(static_cast<std::size_t>(at), table.size() - 2);
  const double share = at - static_cast<double>(i);
  return (1 - share) * table[i] + share * table[i + 1];
}

WallLimit WallLimits::Along(const Matrix3d& J, const Vector3d& normal_W) const {
  double compliance = 0, friction = 0, step = 0;
  for (int i = 0; i < 3; ++i) {
    const double g = J.col(i).squaredNorm(), c = std::abs(J.col(i).dot(normal_W));
    if (!(c > 0)) continue;
    compliance += c * c / AxisStability(i, std::sqrt(g));
    friction += device_.friction[i] * c / g;
    step += device_.encoder_step[i] * c;
  }
  return {1 / compliance, step > 0 ? 2 * friction / step : kInfinite};
}

WallLimit WallLimits::InEveryDirection(const Matrix3d& J) const {
  WallLimit least{kInfinite, kInfinite};
  for (int i = 0; i < 3; ++i) {
    const double g = J.col(i).squaredNorm(), step = device_.encoder_step[i];
    least.stability = std::min(least.stability, AxisStability(i, std::sqrt(g)) / g);
    if (step > 0) least.friction = std::min(least.friction, 2 * device_.friction[i] / (g * step));
  }
  return least;
}

}  // namespace hpdm
