#pragma once

namespace hpdm {

/// Default force limit, N: one standard deviation (0.4 N) above the largest force of experts (2.6
/// N) in a suturing task on artificial tissue; novices reached 4.7 N (Horeman et al. 2010). The
/// forces that tissues bear differ tenfold (Rodrigues et al. 2012), so the trainer sets the limit.
inline constexpr double kDefaultForceLimit = 3;
/// Default depth limit of a press below the released surface, m. It is our own: organs differ in
/// thickness and support, so the trainer sets it too.
inline constexpr double kDefaultDepthLimit = 0.02;

/// Limits for careful handling of tissue. The trainer sets both.
struct HandlingLimits {
  double force = kDefaultForceLimit;  ///< N, on the hand.
  double depth = kDefaultDepthLimit;  ///< m, of the tip below the released surface.
  bool operator==(const HandlingLimits&) const = default;
};

}  // namespace hpdm
