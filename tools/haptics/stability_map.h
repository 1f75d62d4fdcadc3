#pragma once

#include <string>
#include <vector>

#include "haptics/safety/stability.h"

namespace hpdm {

struct StabilityOptions {
  AxisDynamics device = {.mass = 0.1, .damping = 0.5};  ///< Device without a hand.
  double friction = 0.1;                                ///< N, Coulomb, in the cases that include
                                                        ///< it.
  double encoder_step = 2.5e-5;                         ///< m, in the cases that include it.
  double hand_damping = 6;                              ///< N s/m.
  double hand_stiffness = 300;                          ///< N/m.
  double period = 1e-3;                                 ///< s, in the sweep of the delay.
  bool quick = false;  ///< Few points in a few seconds: the ends and middles of both ranges.
};

/// Holder of the device, and the modelled device effects.
enum class StabilityCase {
  kBare,        ///< No hand, no friction, continuous encoder: linear, compared with the exact
                ///< roots.
  kHand,        ///< The same in a hand: damping b + b_hand, spring k_hand.
  kHandDevice,  ///< Hand, device friction and encoder: the complete loop.
};

/// The largest stiffness that one closed loop displays without vibrating.
struct StabilityRow {
  StabilityCase of = StabilityCase::kBare;
  bool control = false;   ///< Passivity controller on.
  bool by_delay = false;  ///< Belongs to the sweep of the delay; otherwise of the period.
  double period = 0;      ///< s.
  double delay = 0;       ///< s, in addition to the hold.
  double damping = 0;     ///< N s/m, device and hand: b + b_hand.
  double measured = 0;    ///< N/m.
  bool beyond = false;    ///< Still stable at `measured`, the largest stiffness tried.
  double exact = 0;       ///< N/m, StabilityLimit() for the same damping and spring.
  double passivity = 0;   ///< N/m, PassivityBound() of the device alone with friction and encoder,
                          ///< without the delay: min(2 b / T, 2 f_c / step).
  double delayed_passivity = 0;  ///< N/m, the same with the delay.
};

struct StabilityMap {
  StabilityOptions options;
  std::vector<StabilityRow> rows;
};

/// Measures the stability limit of the closed loop of hand, device and tissue. Delays are 0-5 ms,
/// periods 0.25-4 ms, with the controller off and on. Deterministic.
///
/// The loop is the production one (HapticLoop: reaction, controller, guard and device limits), in
/// virtual time, against a plane with a spring of Eq. 29. The device is a StabilityPlant pushed
/// with 1 N, so that the tip stays in contact. At equilibrium it is disturbed (stability_trial.h):
/// the linear case without controller by a small kick, other cases by 20 mm/s, as by a hand. Then the
/// force must stay within 0.25 N, a quarter of the push.
///
/// The search multiplies a low stiffness by 1.3 until the first unstable one, then bisects to 0.2
/// %.
StabilityMap MeasureStability(const StabilityOptions& options);

/// Returns the largest |measured / exact - 1| of the linear rows: without friction and controller.
double LargestDeviation(const StabilityMap& map);

/// Writes one line per row with the columns case, control, sweep, period_s, delay_s,
/// damping_N_s_per_m, measured_N_per_m, beyond, exact_N_per_m, passivity_N_per_m,
/// delayed_passivity_N_per_m. Throws InputError.
void WriteStabilityCsv(const StabilityMap& map, const std::string& path);

/// Writes stability.csv into the existing `folder` and draws stability.png beside it. Returns an
/// empty string, or the reason why there is no picture. Throws InputError if the table cannot be
/// written.
std::string WriteStability(const StabilityMap& map, const std::string& folder);

}  // namespace hpdm
