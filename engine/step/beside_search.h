#pragma once

#include <span>

#include "engine/organ/organ_state.h"

namespace hpdm {

/// Finds the place of an organ's deformed surface that a tip at `p` touches first beside other places,
/// as on the far wall of a notch or on the next fold: `p` lies outside, the distance to it grows on all
/// sides of the place, and the direction to it is turned from all `normals` (IsApart,
/// patch_surface.h). The nearest one within `reach` (m); `at.triangle` is -1 if there is none. A convex
/// surface has none, nor has one that curves inwards less than the tip's distance. Costs as many
/// triangles as lie within reach. Deformation thread; allocates nothing.
SurfaceHit FindBeside(const OrganModel& model, const OrganState& state, const Vector3d& p,
                      double reach, std::span<const Vector3d> normals);

}  // namespace hpdm
