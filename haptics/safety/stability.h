#pragma once

#include <algorithm>
#include <array>

#include "engine/base/types.h"
#include "haptics/device/device_axes.h"

namespace hpdm {

/// One axis of a device, with what holds it: m x'' = F - b x' - k x.
struct AxisDynamics {
  double mass = 0.1;     ///< m, kg; above 0.
  double damping = 0;    ///< b, N s/m.
  double stiffness = 0;  ///< k of a hand's spring, N/m.
};

/// What a force that is held constant for a time t makes of the state: (x, v) <- transition (x, v)
/// + input F. Exact.
struct HeldForceStep {
  Eigen::Matrix2d transition = Eigen::Matrix2d::Identity();
  Eigen::Vector2d input = Eigen::Vector2d::Zero();
};

/// The closed form of the matrix exponential, with sigma = b / 2m and q^2 = sigma^2 - k / m:
///     exp(A t) = e^(-sigma t) (cosh(q t) I + sinh(q t) / q (A + sigma I)),
/// in which an imaginary q makes cosine and sine. t >= 0 in s. Any thread, no allocation.
HeldForceStep ExactStep(const AxisDynamics& axis, double t);

/// The greatest stiffness (N/m) of a sampled virtual spring that a device can display passively,
/// whatever holds it:
///     K <= min(2 b / (T + 2 delay), 2 f_c / step).
/// The first is Colgate and Schenkel's condition (1997): the device's damping b (N s/m) dissipates
/// at least what the hold over the period T (s) generates. With a delay (s) of d periods it reads b
/// >= K T/2 sin((d + 1/2) w T) / sin(w T/2) for every frequency w, which is greatest at 0. The
/// second (Abbott and Okamura 2005; Diolaiti, Niemeyer, Barbagli and Salisbury 2006): its Coulomb
/// friction f_c (N) dissipates what an encoder of the given step (m) lets the spring generate. A
/// continuous encoder, 0, leaves the first.
double PassivityBound(double damping, double friction, double encoder_step, double period,
                      double delay = 0);

/// Greatest magnitude of the eigenvalues of the closed loop of an axis and a sampled spring: at t =
/// j T, F = -K x(j T) is commanded; it acts `delay` later, and is held for T. `delay` is any number
/// of seconds >= 0. Stable below 1. Set-up: allocates.
double SpectralRadius(const AxisDynamics& axis, double stiffness, double period, double delay);

/// The stiffness K (N/m) at which that loop loses its stability, to 1e-6 of itself: bisection on
/// SpectralRadius. The loop's phase falls steadily with the frequency, so it is stable for every
/// stiffness below. 0 without damping. Set-up: allocates.
double StabilityLimit(const AxisDynamics& axis, double period, double delay);

/// The stiffness (N/m) with which rigid surfaces are displayed: half of StabilityLimit(), a gain
/// margin of two, for the delay that the device really has.
inline double VirtualWallStiffness(const AxisDynamics& axis, double period, double delay) {
  return 0.5 * StabilityLimit(axis, period, delay);
}

/// How stiff a surface an axis can display, in the axis' own unit (N m/rad or N/m). At the tip,
/// along the direction in which the axis moves it, the limits are these over g, the squared length
/// of its column of J = d p_tip / d q: inertia, damping and stiffness there are those of the axis
/// over g.
struct StiffnessLimit {
  double passivity = 0;  ///< PassivityBound().
  double stability = 0;  ///< StabilityLimit() without a hand.
  double Least() const { return std::min(passivity, stability); }
};

/// Of pitch, yaw and insertion. Period and delay in s.
std::array<StiffnessLimit, 3> StiffnessLimits(const DeviceAxes& axes, double period, double delay);

}  // namespace hpdm
