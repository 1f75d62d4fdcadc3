#pragma once

#include "engine/types.h"

namespace hpdm {

/// A box in space: the points origin_W + axes * s with 0 <= s_k <= lengths_k.
struct OrientedBox {
  Vector3d origin_W = Vector3d::Zero();  ///< A corner, m.
  Matrix3d axes = Matrix3d::Identity();  ///< Columns: unit vectors, orthogonal, in the world.
  Vector3d lengths = Vector3d::Ones();   ///< m, > 0.
};

}  // namespace hpdm
