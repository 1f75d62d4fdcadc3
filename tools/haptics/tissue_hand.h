#pragma once

#include <vector>

#include "engine/snapshots.h"
#include "haptics/device/instrument_options.h"

/// A simulated hand on a simulated device that handles viscoelastic tissue, both production loops in
/// lockstep: the energy that the hand is given. Springs and dampers only take energy; what patches,
/// hold and guard add must stay small.
namespace hpdm {

/// A session of the hand.
struct HandCourse {
  std::vector<ToolSample> ticks;
  /// J, work of the motors on the device before each tick: the effort, held from tick to tick, times
  /// the way of the true joints.
  std::vector<double> work;
};

/// Lets a hand follow `script` at the top of an ellipsoid of half-axes 0.1 x 0.07 x 0.05 m and 5 kPa
/// in the long term for `seconds`.
HandCourse HandleTissue(const PronySeries& prony, HandScript script, double seconds = 10);

/// Returns the most energy that the motors had given at any time, J.
double MostGiven(const HandCourse& course);
/// Returns the most energy that the tissue's law itself had given at any time, J: the force before
/// the guard, trapezoidal, along the measured way of the tip. The rest of MostGiven() comes from
/// holding the force over a tick; below the passivity bound the device's own damping dissipates that.
double MostGivenByLaw(const HandCourse& course);
/// Returns the largest displayed force, N.
double LargestForce(const HandCourse& course);
/// Returns how often the jaws took tissue.
int Grasps(const HandCourse& course);
/// Returns the number of reversals of the displayed force along z; forces below 0.1 N do not count.
int Reversals(const HandCourse& course);

}  // namespace hpdm
