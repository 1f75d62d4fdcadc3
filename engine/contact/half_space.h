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

/// The half-space's response to a load at the distance d, over all directions (half_space.cc):
///     u = H(direction) f,   see SurfaceGreen.
/// Unit of both: 1/m. For a point load both are 1 / (pi d).
struct PairSinking {
  double mean = 0;    ///< Normal sinking; for tangential forces also the sum of both directions.
  double radial = 0;  ///< The part of a tangential force along the line between both loads.
  double inward = 0;  ///< Exchange between normal and tangential: 1/2 e/d for a point load.
};

/// Returns the mean response of one patch to the other at the distance `d` (m). Both patches have
/// the kernel of `radius` (m). The error is within 1e-3 of the value at d = 0.
PairSinking KernelPairSinking(double d, double radius);

/// Returns the mean response of one rectangle under uniform traction to another one at the
/// distance `d` > 0 (m), or to itself at d = 0. The sides are in m. Two terms of the multipole
/// series: the rectangles are no longer than their distance.
PairSinking UniformPairSinking(double d, const Eigen::Vector2d& sides,
                               const Eigen::Vector2d& other_sides);

/// Returns the displacement at one place of the surface of a half-space for a unit force at
/// another one, m/N (Boussinesq and Cerruti). `offset_W` points from the force to the place (m);
/// its part along the outward `normal_W` is dropped. Symmetric under exchange:
/// SurfaceGreen(-offset) = SurfaceGreen(offset)^T.
Matrix3d SurfaceGreen(const MaterialOptions& material, const Vector3d& normal_W,
                      const Vector3d& offset_W, const PairSinking& sinking);

/// Returns the shape of LocalIndentation, 1/m, with g = KernelSinking:
///     g(d / radius) / radius - g(d / resolved_radius) / resolved_radius.
/// Zero beyond IndentationReach().
double IndentationProfile(double d, double radius, double resolved_radius);

/// Returns the distance (m) where the profile has faded to less than 1e-3 of the resolved radius'
/// own part. Zero for equal radii, which leave no indentation.
inline double IndentationReach(double radius, double resolved_radius) {
  return radius < resolved_radius ? 4 * resolved_radius : 0;
}

/// The indentation by a load on a small patch that a lattice does not resolve: the kernel of a
/// constant radius, or the contact of a rigid ball, whose radius grows with the force.
///
/// A force f with the kernel of `radius` acts on the lattice with the kernel of the larger
/// `resolved_radius`. Away from the patch both act alike; near it the difference is that of an
/// elastic half-space,
///     u(d) = H f IndentationProfile(d, radius, resolved_radius)
///     H = ((1 - nu^2) n n^T + (1 + nu)(1 - nu/2)(I - n n^T)) / E.
/// The tangential part of H is the mean over directions (Cerruti). Small strain. Zero for equal
/// radii.
///
/// A frictionless rigid ball of the same radius R obeys Sneddon (1965), with a the radius of its
/// contact and E* = E / (1 - nu^2):
///     approach  delta = (a/2) ln((R+a)/(R-a)),   f_n = E* ((a^2+R^2)/2 ln((R+a)/(R-a)) - a R).
/// For small a this is Hertz's contact. It acts like the kernel of the smaller radius
///     R_ball(f_n) = g_mean f_n / (E* delta),   g_mean = MeanKernelSinking().
/// From a = R / (2 g_mean) on, where ball and kernel are equally stiff, delta grows as under the
/// kernel: at delta = R f_n is 3 % below Sneddon's. Below a = R / 100 delta is proportional to f_n.
///
/// In viscoelastic tissue a contact with known memory obeys the same law with the equilibrium force
///     phi = dent_force + f_n / stiffening
/// in place of f_n (IndentationMemory): the surface then sinks by phi q(phi) - dent_force
/// q(dent_force) from its place without force.
///
/// Any thread, no allocation.
class LocalIndentation {
 public:
  /// Makes no indentation.
  LocalIndentation() = default;
  /// The surface carries a load of `radius` (m) as it is and does not indent.
  explicit LocalIndentation(double radius) : radius_(radius), resolved_radius_(radius) {}
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

  /// True if a ball indents the surface.
  bool indents() const { return E_star_ > 0; }
  /// Returns the indentation by the kernel with which a rigid ball presses with `f_n` (N).
  LocalIndentation UnderBall(double f_n) const;
  /// Returns the law of a contact with memory. `stiffening` >= 1; `dent_force` >= 0, N: the
  /// equilibrium force without f_n.
  LocalIndentation WithMemory(double stiffening, double dent_force) const;
  /// Returns the same on a surface that has turned by `rotation`.
  LocalIndentation Turned(const Matrix3d& rotation) const {
    LocalIndentation turned = *this;
    turned.normal_W_ = rotation * normal_W_;
    turned.factor_W_ = rotation * factor_W_ * rotation.transpose();
    return turned;
  }
  /// Returns q(f_n), 1/m: UnderBall(f_n) has the compliance q H.
  double BallYield(double f_n) const;
  /// Returns d(f_n q) / d f_n, 1/m.
  double BallYieldRate(double f_n) const;
  /// Returns the f_n >= 0 (N) with  f_n (compliance + along q(f_n)) = depth  for a depth (m) and
  /// compliance (m/N) above zero. `along`: n^T H n or its like, m^2/N.
  double PressingForce(double depth, double compliance, double along) const;

  const Vector3d& normal_W() const { return normal_W_; }
  double radius() const { return radius_; }
  double resolved_radius() const { return resolved_radius_; }
  /// H, m^2/N.
  const Matrix3d& factor_W() const { return factor_W_; }

 private:
  double Yield(double force) const;      // q of the law without memory, 1/m
  double YieldRate(double force) const;  // d(f q)/df of the law without memory, 1/m
  double Balance(double depth, double compliance, double along) const;

  Vector3d normal_W_ = Vector3d::UnitZ();
  Matrix3d factor_W_ = Matrix3d::Zero();  // H, m^2/N
  double radius_ = 1;
  double resolved_radius_ = 1;
  double E_star_ = 0;      // Pa
  double stiffening_ = 1;  // of a contact with memory
  double dent_force_ = 0;  // N
};

}  // namespace hpdm
