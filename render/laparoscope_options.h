#pragma once

#include "engine/types.h"

namespace hpdm {

/// Where the laparoscope is and what it sees, validated by the loader (scenes/scene.h).
struct LaparoscopeOptions {
  Vector3d p_scope_W = Vector3d(0, -0.25, 0.12);  ///< Tip of the scope, m.
  Vector3d p_target_W = Vector3d::Zero();         ///< Point in the middle of the picture, m.
  double angle = 0;                               ///< rad, of the optics: 0, 30 or 45 degrees.
  double field_of_view = 1.2;                     ///< rad, across the circular picture.
};

}  // namespace hpdm
