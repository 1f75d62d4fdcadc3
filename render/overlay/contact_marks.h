#pragma once

#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "render/overlay/mark_renderer.h"

namespace hpdm {

inline constexpr double kArrowLength = 0.03;  ///< m a newton, of the drawn force.

/// A tip's contact on the deformed surface: the vertices of the triangles that its kernel touches
/// as points, the surface's normal, and the force on the hand (opposite to the one on the tissue,
/// so that it stands out of the organ) as an arrow of kArrowLength. Nothing without a force.
/// O(triangles). Render thread.
void AddContactMarks(const SolvedContact& contact, const OrganSnapshot& shape,
                     const Triangles& triangles, Marks* marks);

}  // namespace hpdm
