#pragma once

#include <functional>

#include "tools/haptics/stability_plant.h"

namespace hpdm {

/// The disturbance of a plant at rest, and the judgement of its motion.
struct StabilityTrial {
  double stiffness = 0;  ///< N/m, of the tissue along the guide.
  double mass = 0;       ///< kg, along the guide.
  bool linear = false;   ///< Rule 1, otherwise rule 2.
  double kick = 0.02;    ///< m/s, of rule 2.
  double quiet = 0.25;   ///< N, of rule 2.
  int ticks = 0;
};

/// Releases a plant that is held in equilibrium, runs `tick` and returns true if the loop is stable.
/// 1. Linear loops get a kick that moves the tip about a nanometre. Unstable if the energy about
///    the equilibrium is not smaller in the run's fourth quarter than in its third.
/// 2. Others get the kick of a hand. Stable if in the last quarter the tissue's force stays within
///    `quiet` of its middle.
/// A tip that moves by more than 50 mm is unstable under both.
bool IsStable(const StabilityTrial& trial, StabilityPlant* plant,
              const std::function<void()>& tick);

struct StabilityBoundary {
  double value = 0;     ///< The greatest stable value; 0: not even the least one tried.
  bool beyond = false;  ///< Still stable at `value`, the greatest one tried.
};

/// Searches a boundary: multiplies `least` by `growth` until the first unstable value, at most
/// `greatest`, then bisects to the relative `tolerance`.
StabilityBoundary FindBoundary(double least, double greatest, double growth, double tolerance,
                               const std::function<bool(double)>& is_stable);

}  // namespace hpdm
