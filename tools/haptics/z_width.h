#pragma once

#include <string>
#include <vector>

#include "tools/haptics/contact_loop.h"
#include "tools/haptics/contact_tables.h"

namespace hpdm {

/// The largest stiffness that one contact displays stably under one set of conditions, N/m along
/// the guide.
struct ZWidthPoint {
  std::string contact;
  std::string sweep;  ///< What varies: "rate", "delay", "hand" or "loop".
  DisplayConditions display = {};
  bool steps = false;  ///< With the 30 Hz steps.
  double shipped = 0;  ///< Of the scene, at the reference pose.
  double measured = 0;
  bool beyond = false;   ///< Still stable at `measured`, the stiffest tried.
  double exact = 0;      ///< StabilityLimit() of device and hand without friction, encoder and
                         ///< controller: the closed form of a linear loop.
  double passivity = 0;  ///< 2 b / (T + 2 delay) with the damping of device and hand (Colgate
                         ///< and Brown 1994; Colgate and Schenkel 1997).
  double friction = 0;   ///< 2 f_c / encoder step of the device (Diolaiti et al. 2006).
};

/// Measures the Z-width of contacts: how stiff their tissue can become until the loop vibrates.
///
/// The loop is the production one (contact_loop.h) on the patches of the reference pose, made
/// stiffer as a whole. The tip moves along a guide, as Z-widths are measured, comes in at 20 mm/s
/// until it presses with 1 N, and gets the kick of a hand (stability_trial.h) in three runs: 20 mm/s
/// in and out and 5 mm/s, at three phases of the encoders. All must be stable. The stiffness is the
/// tangent's at 1 N. A contact is measured at the scene's rate, delay and hand; then with one of
/// them varied, without the controller, without the guard's limits, and with the 30 Hz steps.
/// `quick`: fewer points and shorter runs. Deterministic.
std::vector<ZWidthPoint> MeasureZWidth(const ShippedContact& contact, bool quick);

/// Measures one point.
ZWidthPoint MeasureZWidthPoint(const ShippedContact& contact, const DisplayConditions& display,
                               bool steps, bool linear, double seconds);

/// Returns the tables: each contact at the scene's conditions, and against rate, delay and hand.
/// Judged: the shipped stiffness is at most half of the largest stable one, and without friction,
/// encoder and controller the boundary is that of the exact roots.
std::vector<ContactTable> ZWidthTables(const std::vector<ZWidthPoint>& points);

/// Writes a line for each point with the columns contact, sweep, rate_hz, delay_s, hand, control,
/// guard, ideal, steps, shipped_N_per_m, measured_N_per_m, beyond, exact_N_per_m,
/// passivity_N_per_m, friction_N_per_m. Throws InputError.
void WriteZWidthCsv(const std::vector<ZWidthPoint>& points, const std::string& path);

}  // namespace hpdm
