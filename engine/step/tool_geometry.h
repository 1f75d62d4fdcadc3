#pragma once

namespace hpdm {

/// Default radius of tips and shafts, m: a 5 mm instrument.
inline constexpr double kDefaultToolRadius = 0.0025;

/// What the loops know of an instrument that a hand can hold (ToolPose::instrument_index).
struct ToolGeometry {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m; the haptic loop has no use for it.
  double friction = 0;     ///< Coulomb coefficient; the deformation loop has it from the tick.
  bool can_grasp = false;  ///< The haptic loop has it from the patch.
};

}  // namespace hpdm
