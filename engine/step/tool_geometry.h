#pragma once

namespace hpdm {

/// What the loops know of an instrument that a hand can hold (ToolPose::instrument_index).
struct ToolGeometry {
  double tip_radius = 0.0025;    ///< m.
  double shaft_radius = 0.0025;  ///< m; the haptic loop has no use for it.
  double friction = 0;     ///< Coulomb coefficient; the deformation loop has it from the tick.
  bool can_grasp = false;  ///< The haptic loop has it from the patch.
};

}  // namespace hpdm
