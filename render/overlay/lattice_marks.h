#pragma once

#include "engine/organ.h"
#include "engine/snapshots.h"
#include "render/overlay/mark_renderer.h"

namespace hpdm {

/// Where the control points are: those of the lattice at their Greville abscissae (Eq. 4 with them
/// is the map itself), each displaced by its own U, n x 3, m, world. Render thread.
Points DisplacedControlPoints(const Lattice& lattice, const OrganSnapshot& shape);

/// Where the local functions in use act most, displaced by the lattice and by themselves, one row
/// each, m, world.
Points DisplacedLocalFunctions(const OrganModel& model, const OrganSnapshot& shape);

/// How strongly each control point is drawn, 0..1 (n), by the share of the surface that it moves:
/// one that holds hardly any tissue may be far out, where nothing follows it, and would hide the
/// others. O(V).
Eigen::VectorXf ControlPointPresence(const OrganModel& model);

/// The control lattice of an organ that has one, and its local functions in use: points, and lines
/// between neighbours in the lattice's grid; fainter, or left out, where they hold little tissue.
void AddLatticeMarks(const OrganModel& model, const Eigen::VectorXf& presence,
                     const OrganSnapshot& shape, Marks* marks);

}  // namespace hpdm
