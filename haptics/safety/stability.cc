#include "haptics/safety/stability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/base/check.h"

namespace hpdm {
namespace {

constexpr double kStiffest = 1e15;  // N/m

}  // namespace

HeldForceStep ExactStep(const AxisDynamics& axis, double t) {
  const double m = axis.mass, b = axis.damping, k = axis.stiffness;
  const double sigma = 0.5 * b / m;
  const double q2 = sigma * sigma - k / m;
  const double q = std::sqrt(std::abs(q2));
  // Real roots. The slow one as q - sigma would lose precision under a weak spring.
  const double fast_root = -(q + sigma), slow_root = -k / m / (q + sigma);
  double c = 0, s = 0;  // e^(-sigma t) cosh(q t) and e^(-sigma t) sinh(q t) / q
  if (q * t < 1e-6) {
    c = std::exp(-sigma * t);
    s = t * c;
  } else if (q2 > 0) {
    // Sums of decaying terms: cosh alone would overflow for large t.
    const double slow = std::exp(slow_root * t), fast = std::exp(fast_root * t);
    c = 0.5 * (slow + fast);
    s = 0.5 * (slow - fast) / q;
  } else {
    const double decay = std::exp(-sigma * t);
    c = decay * std::cos(q * t);
    s = decay * std::sin(q * t) / q;
  }
  HeldForceStep step;
  step.transition << c + sigma * s, s, -k / m * s, c - sigma * s;
  // A unit force held since t = 0 gives the velocity v = s / m, which is also the position after a
  // unit impulse. The position x is the integral of v.
  const double v = s / m;
  double x = 0;
  if (b * t < m && k * t * t < m) {
    // The closed form loses precision here: use the power series of m x'' + b x' + k x = 1.
    double term = 0.5 * t * t / m, before = 0;  // c_n t^n, c_(n-1) t^(n-1)
    x = term;
    for (int n = 3; n < 60 && std::abs(term) + std::abs(before) > 1e-18 * x; ++n) {
      const double next = -(b / m * t / n * term + k / m * t * t / (n * (n - 1)) * before);
      before = term;
      term = next;
      x += term;
    }
  } else if (q2 > 0 && q > 0.5 * sigma) {
    const double slow = slow_root < 0 ? std::expm1(slow_root * t) / slow_root : t;
    x = 0.5 * (slow - std::expm1(fast_root * t) / fast_root) / (q * m);
  } else {
    x = (1 - step.transition(0, 0)) / k;
  }
  step.input << x, v;
  return step;
}

double PassivityBound(double damping, double friction, double encoder_step, double period,
                      double delay) {
  const double of_damping = 2 * damping / (period + 2 * delay);
  return encoder_step > 0 ? std::min(of_damping, 2 * friction / encoder_step) : of_damping;
}

double SpectralRadius(const AxisDynamics& axis, double stiffness, double period, double delay,
                      const SampledDamper& damper) {
  // Within a period, the command of d + 1 periods ago acts first, then the one of d periods ago.
  const int d = static_cast<int>(delay / period + 1e-9);
  const double first = std::max(0.0, delay - d * period);
  const HeldForceStep whole = ExactStep(axis, period);
  const HeldForceStep early = ExactStep(axis, first);
  const HeldForceStep late = ExactStep(axis, period - first);

  // State: x, v, the commands of 1, 2, .. d + 1 periods ago, and with a damper the positions of 1,
  // 2, .. w periods ago.
  const int w = damper.damping > 0 ? damper.window : 0;
  const int size = 3 + d + w;
  Eigen::RowVectorXd command = Eigen::RowVectorXd::Zero(size);
  command[0] = -stiffness;
  if (w > 0) {
    const double rate = damper.damping / (w * period);
    command[0] -= rate;
    command[size - 1] += rate;
  }
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size, size);
  A.topLeftCorner<2, 2>() = whole.transition;
  A.block<2, 1>(0, 2 + d) = late.transition * early.input;
  if (d == 0) {
    A.topRows<2>() += late.input * command;
  } else {
    A.block<2, 1>(0, 1 + d) += late.input;
  }
  A.row(2) = command;
  for (int i = 0; i < d; ++i) A(3 + i, 2 + i) = 1;
  for (int i = 0; i < w; ++i) A(3 + d + i, i == 0 ? 0 : 2 + d + i) = 1;
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

double StabilityLimit(const AxisDynamics& axis, double period, double delay,
                      const SampledDamper& damper) {
  HPDM_CHECK(axis.mass > 0 && period > 0 && delay >= 0 && damper.window > 0);
  const double damping = axis.damping + damper.damping;
  if (!(damping > 0)) return 0;
  double low = 0, high = 1e-3 * damping / period;
  while (high < kStiffest && SpectralRadius(axis, high, period, delay, damper) < 1) {
    low = high;
    high *= 2;
  }
  while (high - low > 1e-6 * high) {
    const double middle = 0.5 * (low + high);
    (SpectralRadius(axis, middle, period, delay, damper) < 1 ? low : high) = middle;
  }
  return low;
}

std::array<StiffnessLimit, 3> StiffnessLimits(const DeviceAxes& axes, double period, double delay) {
  std::array<StiffnessLimit, 3> limits;
  for (int i = 0; i < 3; ++i) {
    limits[i].passivity =
        PassivityBound(axes.damping[i], axes.friction[i], axes.encoder_step[i], period, delay);
    limits[i].stability = StabilityLimit({axes.inertia[i], axes.damping[i]}, period, delay);
  }
  return limits;
}

}  // namespace hpdm
