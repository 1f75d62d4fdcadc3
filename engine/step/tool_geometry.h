#pragma once

namespace hpdm {

/// Default radius of tips and shafts, m: a 5 mm instrument.
inline constexpr double kDefaultToolRadius = 0.0025;

/// Geometry of an instrument that a hand can hold (ToolPose::instrument_index), for both loops.
struct ToolGeometry {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m; deformation loop only.
  double friction = 0;     ///< Coulomb coefficient; haptic loop only (sent with each tick).
  bool can_grasp = false;  ///< Deformation loop only (sent with each patch).
};

}  // namespace hpdm
