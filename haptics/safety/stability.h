#pragma once

#include <algorithm>
#include <array>

#include "engine/base/types.h"
#include "haptics/device/device_axes.h"

namespace hpdm {

/// One axis of a device with the hand that holds it: m x'' = F - b x' - k x.
struct AxisDynamics {
  double mass = 0.1;     ///< m, kg; above 0.
  double damping = 0;    ///< b, N s/m.
  double stiffness = 0;  ///< k of a hand's spring, N/m.
};

/// Exact step of the state under a constant force: (x, v) <- transition (x, v) + input F.
struct HeldForceStep {
  Eigen::Matrix2d transition = Eigen::Matrix2d::Identity();
  Eigen::Vector2d input = Eigen::Vector2d::Zero();
};

/// Returns the step over t (s, >= 0) from the closed form of the matrix exponential:
///     exp(A t) = e^(-sigma t) (cosh(q t) I + sinh(q t) / q (A + sigma I)),
/// with A = [0, 1; -k/m, -b/m], sigma = b / 2m and q^2 = sigma^2 - k / m. If q is imaginary, cosh
/// and sinh become cos and sin. Any thread, no allocation.
HeldForceStep ExactStep(const AxisDynamics& axis, double t);

/// Returns the greatest stiffness (N/m) of a sampled virtual spring that a device can display
/// passively in any hand:
///     K <= min(2 b / (T + 2 delay), 2 f_c / step).
/// 1. Colgate and Schenkel (1997): the device's damping b (N s/m) dissipates at least the energy
///    that the hold over the period T (s) generates. With a delay (s) of d periods,
///        b >= K T/2 sin((d + 1/2) w T) / sin(w T/2)
///    for every frequency w; the bound is greatest at w = 0.
/// 2. Abbott and Okamura (2005); Diolaiti, Niemeyer, Barbagli and Salisbury (2006): Coulomb
///    friction f_c (N) dissipates what an encoder's step (m) lets the spring generate. It does not
///    apply to a continuous encoder (step 0).
double PassivityBound(double damping, double friction, double encoder_step, double period,
                      double delay = 0);

/// A damper in the loop that takes its velocity from two samples, `window` periods apart.
struct SampledDamper {
  double damping = 0;  ///< D, N s/m.
  int window = 1;      ///< w, periods; at least 1.
};

/// Returns the spectral radius of the closed loop of an axis and a sampled spring; stable below 1.
/// At t = j T the force F = -K x(j T) - D (x(j T) - x((j - w) T)) / (w T) is commanded. It acts
/// `delay` (s, >= 0) later and is held for T. Set-up: allocates.
double SpectralRadius(const AxisDynamics& axis, double stiffness, double period, double delay,
                      const SampledDamper& damper = {});

/// Returns the stiffness K (N/m) at which that loop becomes unstable, to a relative 1e-6, by
/// bisection on SpectralRadius. Without a damper the loop's phase falls monotonically with the
/// frequency, so it is stable for every lower stiffness. 0 without any damping. Set-up: allocates.
double StabilityLimit(const AxisDynamics& axis, double period, double delay,
                      const SampledDamper& damper = {});

/// Greatest stiffness that an axis can display, in the axis' own unit (N m/rad or N/m). For its
/// value at the tip, divide it by the squared length of the axis' column of J = d p_tip / d q.
/// Inertia and damping convert in the same way.
struct StiffnessLimit {
  double passivity = 0;  ///< PassivityBound().
  double stability = 0;  ///< StabilityLimit() without a hand.
  double Least() const { return std::min(passivity, stability); }
};

/// Returns the limits of pitch, yaw and insertion. Period and delay in s.
std::array<StiffnessLimit, 3> StiffnessLimits(const DeviceAxes& axes, double period, double delay);

}  // namespace hpdm
