#pragma once

#include <cmath>
#include <optional>

#include "engine/base/types.h"

namespace hpdm {

/// Depth of the tip below the trocar where a scene names no trocar, m.
inline constexpr double kScopeDepth = 0.12;

/// Minimum distance from the scope's tip, m, of drawn surfaces, the target and the trocar.
inline constexpr double kScopeNear = 0.002;

/// Pose and optics of the laparoscope, validated by the loader (scenes/loader/scene.h).
struct LaparoscopeOptions {
  Vector3d p_scope_W = Vector3d(0, -0.25, 0.12);  ///< Tip of the scope, m.
  Vector3d p_target_W = Vector3d::Zero();         ///< Point in the middle of the picture, m. With a
                                                  ///< trocar, the optics turn towards this point.
  std::optional<Vector3d> p_trocar_W;             ///< m; absent: on the shaft, kScopeDepth behind
                                                  ///< the tip.
  double angle = 0;            ///< rad, angle of the optics: 0, 30 or 45 degrees.
  double field_of_view = 1.2;  ///< rad, across the circular picture.
  double distortion = 0;  ///< Distortion k of the lens: a ray at the tangent r off the axis appears
                          ///< at r (1 + k r^2 / R^2) / (1 + k), with R the circle's edge.
                          ///< Negative: barrel, as in wide lenses.
  bool operator==(const LaparoscopeOptions&) const = default;
};

/// Diameter of the circular picture on the camera's sensor, m: the longer side of a 1/3 inch
/// sensor, 4.8 mm x 3.6 mm (assumed; laparoscopes differ).
inline constexpr double kImageCircleDiameter = 4.8e-3;

/// Returns the field of view (rad) across the circular picture of a distortion-free lens of focal
/// length f (m): 2 atan(diameter / 2f).
inline double FieldOfView(double focal_length) {
  return 2 * std::atan(kImageCircleDiameter / (2 * focal_length));
}

}  // namespace hpdm
