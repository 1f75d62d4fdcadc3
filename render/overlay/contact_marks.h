#pragma once

#include "engine/mesh/surface_mesh.h"
#include "engine/snapshots.h"
#include "render/overlay/mark_renderer.h"

namespace hpdm {

inline constexpr double kArrowLength = 0.03;  ///< Length of the drawn force, m per newton.

/// Adds marks of a tip's contact on the deformed surface; none without a force:
///   - points at the vertices of the triangles that its kernel touches,
///   - the surface's normal,
///   - the force on the hand as an arrow of kArrowLength, pointing out of the organ.
/// O(triangles). Render thread.
void AddContactMarks(const SolvedContact& contact, const OrganSnapshot& shape,
                     const Triangles& triangles, Marks* marks);

}  // namespace hpdm
