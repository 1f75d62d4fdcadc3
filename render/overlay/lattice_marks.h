#pragma once

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "render/overlay/mark_renderer.h"

namespace hpdm {

/// Returns the lattice's control points, n x 3, m, world: Greville abscissae (with which Eq. 4 is
/// the identity) plus each point's displacement U. Render thread.
Points DisplacedControlPoints(const Lattice& lattice, const OrganSnapshot& shape);

/// Returns the centres of the active local functions, displaced by the lattice and by themselves,
/// one row each, m, world.
Points DisplacedLocalFunctions(const OrganModel& model, const OrganSnapshot& shape);

/// Returns each control point's opacity, 0..1 (n), by the share of the surface that it moves. A
/// point with little tissue may lie far outside and would hide the others. O(V).
Eigen::VectorXf ControlPointPresence(const OrganModel& model);

/// Adds the control lattice of an organ that has one, and its active local functions: points, and
/// lines between neighbours in the lattice's grid. Marks with little tissue are faint or omitted.
void AddLatticeMarks(const OrganModel& model, const Eigen::VectorXf& presence,
                     const OrganSnapshot& shape, Marks* marks);

}  // namespace hpdm
