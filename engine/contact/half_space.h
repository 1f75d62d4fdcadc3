#pragma once

#include "engine/base/types.h"
#include "engine/organ_options.h"

namespace hpdm {

/// Returns the sinking g of an elastic half-space's surface at the distance d = `d_over_R` x R from
/// a load's centre. The load has the kernel cos(pi d / 2R), d < R (surface_kernel.h). The unit is
/// (1 - nu^2) F / (E R) for a force F along the normal.
///
/// It is Boussinesq's solution integrated over the kernel. Continuous; the error is within 1e-4 of
/// the value at the centre. Any thread, no allocation.
double KernelSinking(double d_over_R);

/// Returns the mean of KernelSinking over the load, weighted by the kernel: 0.6729.
double MeanKernelSinking();

/// Returns the shape of LocalIndentation, 1/m, with g = KernelSinking:
///     g(d / radius) / radius - g(d / resolved_radius) / resolved_radius.
/// Zero beyond IndentationReach().
double IndentationProfile(double d, double radius, double resolved_radius);

/// Returns the distance (m) where the profile has faded to less than 1e-3 of the resolved radius'
/// own part. Zero for equal radii, which leave no indentation.
inline double IndentationReach(double radius, double resolved_radius) {
  return radius < resolved_radius ? 4 * resolved_radius : 0;
}

/// The indentation by a load on a small patch that a lattice does not resolve.
///
/// A force f with the kernel of `radius` acts on the lattice with the kernel of the larger
/// `resolved_radius`. Away from the patch both act alike; near it the difference is that of an
/// elastic half-space,
///     u(d) = H f IndentationProfile(d, radius, resolved_radius)
///     H = ((1 - nu^2) n n^T + (1 + nu)(1 - nu/2)(I - n n^T)) / E.
/// The tangential part of H is the mean over directions (Cerruti). Small strain. Zero for equal
/// radii. Any thread, no allocation.
class LocalIndentation {
 public:
  /// Makes no indentation.
  LocalIndentation() = default;
  /// `normal_W`: unit normal of the surface. Requires 0 < radius <= resolved_radius (m).
  LocalIndentation(const MaterialOptions& material, const Vector3d& normal_W, double radius,
                   double resolved_radius);

  /// Returns C_loc (m/N): the mean displacement of the patch, weighted by its kernel, for a unit
  /// force.
  Matrix3d Compliance() const;
  /// Returns the displacement for a unit force at the distance `d` (m) from the patch's centre
  /// along the surface, m/N.
  Matrix3d At(double d) const {
    return IndentationProfile(d, radius_, resolved_radius_) * factor_W_;
  }

  const Vector3d& normal_W() const { return normal_W_; }
  double radius() const { return radius_; }
  double resolved_radius() const { return resolved_radius_; }
  /// H, m^2/N.
  const Matrix3d& factor_W() const { return factor_W_; }

 private:
  Vector3d normal_W_ = Vector3d::UnitZ();
  Matrix3d factor_W_ = Matrix3d::Zero();  // H, m^2/N
  double radius_ = 1;
  double resolved_radius_ = 1;
};

}  // namespace hpdm
