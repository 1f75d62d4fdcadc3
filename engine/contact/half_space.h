#pragma once

#include "engine/base/types.h"
#include "engine/organ_options.h"

namespace hpdm {

/// How deep the surface of an elastic half-space sinks at the distance `d_over_R` x R from the
/// centre of a load with the kernel of surface_kernel.h (cos(pi d / 2R), d < R), in units of
/// (1 - nu^2) F / (E R) for a force F along the normal (Boussinesq's solution, integrated over the
/// kernel). Continuous; within 1e-4 of its value at the centre. Any thread, no allocation.
double KernelSinking(double d_over_R);

/// The same, averaged over the load with the kernel's own weights: 0.6729.
double MeanKernelSinking();

/// g(d / radius) / radius - g(d / resolved_radius) / resolved_radius with g = KernelSinking, 1/m:
/// the shape of the indentation below. Zero beyond IndentationReach().
double IndentationProfile(double d, double radius, double resolved_radius);

/// m: where the shape has faded to less than 1e-3 of the resolved radius' own part; zero for equal
/// radii, which leave no indentation.
inline double IndentationReach(double radius, double resolved_radius) {
  return radius < resolved_radius ? 4 * resolved_radius : 0;
}

/// What a load on a small patch does beyond what a lattice resolves. A force f with the kernel of
/// `radius` is given to the lattice with the kernel of the larger `resolved_radius`, as which it
/// comes to the same away from the patch, and the difference of the two is a half-space's:
///
///     u(d) = H f IndentationProfile(d, radius, resolved_radius)
///
/// with H = ((1 - nu^2) n n^T + (1 + nu)(1 - nu/2)(I - n n^T)) / E, which
/// along the surface is the mean over directions (Cerruti). Small strain. Zero when the radii are
/// equal. Any thread, no allocation.
class LocalIndentation {
 public:
  /// No indentation.
  LocalIndentation() = default;
  /// `normal_W`: unit, of the surface. Requires 0 < radius <= resolved_radius (m).
  LocalIndentation(const MaterialOptions& material, const Vector3d& normal_W, double radius,
                   double resolved_radius);

  /// Mean displacement of the patch (weighted by its kernel) for a unit force: C_loc, m/N.
  Matrix3d Compliance() const;
  /// Displacement at the distance `d` (m) from the patch's centre along the surface for a unit
  /// force, m/N.
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
