#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// A box in the world with its own axes: the frame (X0; S, T, U) of Eq. 1.
struct OrientedBox {
  Vector3d origin_W = Vector3d::Zero();  ///< The corner where all three coordinates are 0, m.
  Matrix3d axes = Matrix3d::Identity();  ///< Columns: unit vectors of the three edges.
  Vector3d lengths = Vector3d::Ones();   ///< Edge lengths, m.

  /// Returns the lattice coordinates of a world point (m), 0..1 inside the box (Eq. 1).
  Vector3d ToUnit(const Vector3d& p_W) const {
    return (axes.transpose() * (p_W - origin_W)).cwiseQuotient(lengths);
  }
  /// Returns the world point (m) of lattice coordinates.
  Vector3d FromUnit(const Vector3d& c) const { return origin_W + axes * c.cwiseProduct(lengths); }

  double Volume() const { return lengths.prod(); }
};

}  // namespace hpdm
