#pragma once

namespace hpdm {

/// Default radius of tips and shafts, m: a 5 mm instrument.
inline constexpr double kDefaultToolRadius = 0.0025;

/// Geometry of an instrument that a hand can hold (ToolPose::instrument_index), for both loops.
struct ToolGeometry {
  double tip_radius = kDefaultToolRadius;    ///< m.
  double shaft_radius = kDefaultToolRadius;  ///< m; deformation loop only.
  double friction = 0;        ///< Coulomb coefficient; haptic loop only (sent with each tick).
  bool can_grasp = false;     ///< Deformation loop only (sent with each patch), like the jaws'.
  double closing_force = 5;   ///< N, with which closed jaws press on tissue between them.
  double jaw_friction = 0.5;  ///< Coulomb coefficient of the jaws' faces.

  /// Returns the largest pull along the jaws' faces that friction on both of them holds, N.
  double Hold() const { return 2 * jaw_friction * closing_force; }
};

}  // namespace hpdm
