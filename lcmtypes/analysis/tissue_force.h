#pragma once

#include <cmath>

#include "engine/snapshots.h"

namespace hpdm {

/// Returns the force that a tick's contact is judged by, world, N: the tissue's on the hand as far
/// as the device displays it. That is the displayed force, except for an instrument with friction
/// in its trocar (kGuardTrocar), whose displayed force contains that friction too: there it is the
/// tissue's force, and of no larger magnitude than the displayed one.
inline Vector3d TissueForce(const ToolSample& tool) {
  if ((tool.guard_flags & kGuardTrocar) == 0) return tool.force_W;
  const double reaction = tool.reaction_W.norm(), displayed = tool.force_W.norm();
  if (reaction <= displayed) return tool.reaction_W;
  if (!std::isfinite(reaction)) return tool.force_W;
  return displayed / reaction * tool.reaction_W;
}

}  // namespace hpdm
