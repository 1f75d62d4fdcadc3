#pragma once

#include "engine/snapshots.h"
#include "haptics/device/instrument_options.h"

namespace hpdm {

/// Mechanics of a device's actuated axes: pitch and yaw (kg m^2, N m s/rad, N m, rad), insertion
/// (kg, N s/m, N, m).
struct DeviceAxes {
  Vector3d inertia = Vector3d::Zero();
  Vector3d damping = Vector3d::Zero();
  Vector3d friction = Vector3d::Zero();      ///< Coulomb.
  Vector3d encoder_step = Vector3d::Zero();  ///< 0: continuous.
};

inline DeviceAxes AxesOf(const DeviceProfile& profile) {
  return {{profile.rotational_inertia, profile.rotational_inertia, profile.mass},
          {profile.rotational_damping, profile.rotational_damping, profile.damping},
          {profile.rotational_friction, profile.rotational_friction, profile.friction},
          {profile.angle_encoder_step, profile.angle_encoder_step, profile.encoder_step}};
}

}  // namespace hpdm
