#pragma once

#include "tools/shared/simple_bodies.h"

namespace hpdm {

/// A pose with no symmetry.
inline Isometry3d SomePose() {
  Isometry3d X = Isometry3d::Identity();
  X.linear() = Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
  X.translation() = Vector3d(0.3, -0.2, 0.1);
  return X;
}

}  // namespace hpdm
