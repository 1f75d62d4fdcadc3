#pragma once

#include <functional>
#include <vector>

#include "tools/haptics/contact_trials.h"

/// Trials of the felt force of viscoelastic tissue: given poses, a step every 33 ticks, no device and
/// no guard.
namespace hpdm {

/// A tip that presses a wide block at one place, straight down.
struct TissuePress {
  WideBlock block;
  PronySeries prony;
  double tip_radius = 0.0025;           ///< m.
  double friction = 0;                  ///< Holds the contact's place.
  Vector3d place_W = Vector3d::Zero();  ///< On the block's top, m.
};

inline constexpr double kTissuePeriod = 0.001;  ///< s, of the ticks.

/// Returns the force on the hand along the vertical in every tick, N. `depth`: of the tip (m,
/// negative above the surface) at the time of the tick (s).
std::vector<double> FeltForce(const TissuePress& press,
                              const std::function<double(double time)>& depth, double seconds);

/// The force of the relaxed tissue over the depth, tabulated: each value is the tick's after a step
/// in that pose, when the force no longer changes.
class RelaxedPress {
 public:
  /// Tabulates up to `deepest`, m. The block is elastic; `press.prony` plays no part.
  RelaxedPress(const TissuePress& press, double deepest);
  /// Returns the force at a depth of at most `deepest`, N; 0 above the surface.
  double Force(double depth) const;

 private:
  double spacing_;
  std::vector<double> roots_;  // F^(2/3), which is nearly linear in the depth under a ball
};

}  // namespace hpdm
