#pragma once

#include <cmath>
#include <optional>

#include "engine/base/types.h"

namespace hpdm {

/// Depth of the tip below the trocar where a scene names no trocar, m.
inline constexpr double kScopeDepth = 0.12;

/// Nothing nearer to the scope's tip is drawn, nor may its target or trocar be, m.
inline constexpr double kScopeNear = 0.002;

/// Where the laparoscope is and what it sees, validated by the loader (scenes/loader/scene.h).
struct LaparoscopeOptions {
  Vector3d p_scope_W = Vector3d(0, -0.25, 0.12);  ///< Tip of the scope, m.
  Vector3d p_target_W = Vector3d::Zero();  ///< m. Without a trocar the middle of the picture; with
                                           ///< one the optics are turned towards it.
  std::optional<Vector3d> p_trocar_W;      ///< m; absent: on the shaft, kScopeDepth behind
                                           ///< the tip.
  double angle = 0;                        ///< rad, of the optics: 0, 30 or 45 degrees.
  double field_of_view = 1.2;              ///< rad, across the circular picture.
  double distortion = 0;  ///< Of the lens: a direction at the tangent r of the angle off the axis
                          ///< appears at r (1 + distortion r^2 / R^2), scaled so that the circle's
                          ///< edge R stays; negative: barrel, as wide lenses have.
};

/// Diameter of the circular picture on the camera's sensor, m: it spans the longer side of a 1/3
/// inch sensor, 4.8 mm x 3.6 mm (assumed; laparoscopes differ).
inline constexpr double kImageCircleDiameter = 4.8e-3;

/// Field of view (rad) across the circular picture of a distortion-free lens of the given focal
/// length (m): 2 atan(diameter / 2f).
inline double FieldOfView(double focal_length) {
  return 2 * std::atan(kImageCircleDiameter / (2 * focal_length));
}

}  // namespace hpdm
