#pragma once

namespace hpdm {

/// Geometry of an instrument that a hand can hold (ToolPose::instrument_index), for both loops.
struct ToolGeometry {
  double tip_radius = 0.0025;    ///< m.
  double shaft_radius = 0.0025;  ///< m; deformation loop only.
  double friction = 0;           ///< Coulomb coefficient; haptic loop only (sent with each tick).
  bool can_grasp = false;        ///< Deformation loop only (sent with each patch).
};

}  // namespace hpdm
