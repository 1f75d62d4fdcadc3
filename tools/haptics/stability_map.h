#pragma once

#include <string>
#include <vector>

#include "haptics/safety/stability.h"

namespace hpdm {

struct StabilityOptions {
  AxisDynamics device = {.mass = 0.1, .damping = 0.5};  ///< Alone.
  double friction = 0.1;                                ///< N, Coulomb, where it is counted.
  double encoder_step = 2.5e-5;                         ///< m, where it is counted.
  double hand_damping = 6;                              ///< N s/m.
  double hand_stiffness = 300;                          ///< N/m.
  double period = 1e-3;                                 ///< s, where the delay changes.
  bool quick = false;  ///< Few points, in a few seconds: the ends and middles of both ranges.
};

/// What holds the device, and what of it is modelled.
enum class StabilityCase {
  kBare,        ///< No hand, no friction, continuous encoder: linear, to be held to the roots.
  kHand,        ///< The same in a hand: damping b + b_hand, spring k_hand.
  kHandDevice,  ///< Hand, and the device's friction and encoder: the loop as it is.
};

/// The greatest stiffness that one closed loop displays without vibrating.
struct StabilityRow {
  StabilityCase of = StabilityCase::kBare;
  bool control = false;   ///< Passivity controller on.
  bool by_delay = false;  ///< On the sweep of the delay; else on that of the period.
  double period = 0;      ///< s.
  double delay = 0;       ///< s, beyond the hold.
  double damping = 0;     ///< N s/m, of device and hand: b + b_hand.
  double measured = 0;    ///< N/m.
  bool beyond = false;    ///< Stable still at `measured`, the stiffest that was tried.
  double exact = 0;       ///< N/m, StabilityLimit() of the same damping and spring.
  double passivity = 0;   ///< N/m, PassivityBound() of the device alone, with its friction and
                          ///< encoder, and without the delay: min(2 b / T, 2 f_c / step).
  double delayed_passivity = 0;  ///< N/m, the same with the delay.
};

struct StabilityMap {
  StabilityOptions options;
  std::vector<StabilityRow> rows;
};

/// Measures where the closed loop of hand, device and tissue loses its stability: delay 0-5 ms and
/// period 0.25-4 ms, controller off and on.
///
/// The loop is the production one (HapticLoop: reaction, controller, guard and device limits), in
/// virtual time, against a plane with a spring of Eq. 29; the device is a StabilityPlant that is
/// pushed with 1 N, so that the tip stays in contact. At equilibrium it gets a push:
///  - linear, controller off: of a nanometre's order. Unstable when the energy about the
///    equilibrium in the run's fourth quarter is not below that in its third.
///  - else 20 mm/s, as of a hand. Stable when the tissue's force varies by less than 0.25 N to
///    either side of its middle, a quarter of the push, in the run's last quarter.
/// From far below upwards in steps of 1.3 until the first unstable stiffness, then bisection to
/// 0.2 %. Deterministic.
StabilityMap MeasureStability(const StabilityOptions& options);

/// The largest |measured / exact - 1| of the rows that are linear: without friction and controller.
double LargestDeviation(const StabilityMap& map);

/// A line a row with the columns case, control, sweep, period_s, delay_s, damping_N_s_per_m,
/// measured_N_per_m, beyond, exact_N_per_m, passivity_N_per_m,
/// delayed_passivity_N_per_m. Throws InputError.
void WriteStabilityCsv(const StabilityMap& map, const std::string& path);

/// Writes stability.csv into `folder`, which exists, and draws stability.png beside it. Returns an
/// empty string, or why there is no picture. Throws InputError when the table cannot be written.
std::string WriteStability(const StabilityMap& map, const std::string& folder);

}  // namespace hpdm
