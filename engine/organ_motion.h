#pragma once

#include <cmath>
#include <numbers>

#include "engine/base/types.h"

namespace hpdm {

/// Rigid motion of an organ by breathing, along a line:
///     offset(t) = displacement (1 - cos(2 pi frequency t)) / 2.
/// It starts from the posed shape at session time 0, before a session's first tick. The offset is
/// kept apart from the deformation: the organ is computed at rest, with the tools moved by minus
/// the offset. Any thread; no allocation.
struct OrganMotion {
  Vector3d displacement_W = Vector3d::Zero();  ///< m.
  double frequency = 0;                        ///< Hz.

  /// m, at session time t_ns.
  Vector3d Offset(Nanoseconds t_ns) const {
    return (1 - std::cos(2 * std::numbers::pi * frequency * ToSeconds(t_ns))) / 2 * displacement_W;
  }
};

}  // namespace hpdm
