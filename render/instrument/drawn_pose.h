#pragma once

#include "engine/snapshots.h"

namespace hpdm {

/// Returns the pose X_WT in which an instrument is drawn.
///
/// A tip that presses a rigid organ stands below its surface, by the force over the wall's
/// stiffness. It is drawn on the surface, as a god-object: with its centre one tip radius (m) above
/// the contact point along the contact's normal, and turned about the trocar so that the shaft
/// still passes through it. Every other tip is drawn where it is. Any thread; allocates nothing.
Isometry3d DrawnPose(const ToolPose& tool, const SolvedContact& contact, double tip_radius);

}  // namespace hpdm
