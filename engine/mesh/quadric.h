#pragma once

#include "engine/base/types.h"

namespace hpdm {

/// Weighted sum of squared distances of a point p to planes (Garland and Heckbert, "Surface
/// simplification using quadric error metrics", 1997):
///     p^T A p - 2 b^T p + c.
class Quadric {
 public:
  /// Adds the plane through `point` (m) with unit `normal`; `weight` is an area, m^2.
  void AddPlane(const Vector3d& normal, const Vector3d& point, double weight);
  Quadric& operator+=(const Quadric& other);

  /// Sum of weights, m^2.
  double weight() const { return weight_; }
  /// Weighted sum of squared distances at p, m^4.
  double Error(const Vector3d& p) const;
  /// Returns the point p that minimises
  ///     Error(p) + strength * weight() * |p - anchor|^2;
  /// strength > 0 determines the directions that the planes leave open.
  Vector3d Minimiser(const Vector3d& anchor, double strength) const;

 private:
  Matrix3d a_ = Matrix3d::Zero();
  Vector3d b_ = Vector3d::Zero();
  double c_ = 0;
  double weight_ = 0;
};

}  // namespace hpdm
