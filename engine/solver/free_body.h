#pragma once

#include "engine/base/quadrature.h"
#include "engine/energy/metric_energy.h"
#include "engine/energy/strain_energy.h"
#include "engine/lattice/lattice.h"

namespace hpdm {

/// An organ's mass and how its control points move with a rigid motion N of the organ about its
/// centre of mass: N_a = [I, -[x_a]x] with x_a the control point a less the centre. Splines
/// reproduce these motions exactly. Constant.
struct FreeBody {
  /// Integrates over `tissue` with a `density` (kg/m^3). Front functions take no part (N_a = 0).
  FreeBody(const Lattice& lattice, const Quadrature& tissue, double density);

  double mass = 0;                         ///< kg: that of N^T M N.
  Vector3d p_centre_W = Vector3d::Zero();  ///< Centre of mass at rest, m.
  Matrix3d inertia = Matrix3d::Zero();     ///< About the centre, at rest, kg m^2.
  Points arms;                             ///< n' x 3, m: x_a. n' <= n, without front functions.
  Eigen::VectorXd masses;                  ///< n', kg: M 1.
  Points moments;                          ///< n' x 3, kg m: M x.

  /// Returns (N^T M N)^-1 N^T M W: the rigid part of the displacements W (>= n' x 3, m), a
  /// translation (m) and a rotation vector (rad).
  struct Motion {
    Vector3d translation = Vector3d::Zero();
    Vector3d rotation = Vector3d::Zero();
  };
  Motion RigidPart(const Points& W) const;

  /// Adds M N (N^T M N)^-1 N^T M / yield to K (3n x 3n, N/m). The inverse of the sum is
  ///     G + yield N (N^T M N)^-1 N^T.
  /// G is the elastic response with inertia relief: its displacements hold no rigid part, and loads
  /// M N, such as gravity's, do not deform the organ. `yield`: s^2.
  void AddInertia(double yield, FullStiffness* K) const;
};

/// How an organ's frame stands and moves. A rest point X is at p_W + R_WF (X - p_centre_W).
struct FreeMotion {
  Matrix3d R_WF = Matrix3d::Identity();
  Vector3d p_W = Vector3d::Zero();         ///< Centre of mass, m.
  Vector3d v_W = Vector3d::Zero();         ///< m/s.
  Vector3d momentum_W = Vector3d::Zero();  ///< Angular, about the centre, kg m^2/s.
};

/// Returns how a body moves that has left its rest pose by a small motion q (m, rad) at a rate (m/s,
/// rad/s). Its rotation is the best fit of the points' ways q x r.
FreeMotion MotionFrom(const FreeBody& body, const FreeBody::Motion& q,
                      const FreeBody::Motion& rate);

/// One step of a body's free flight with linear drag c, over `dt` (s):
///     dv/dt = g - c v,   dL/dt = -c L,   omega = I_W^-1 L.
/// The exact solution for v, p and L; the rotation by the midpoint rule in kSubsteps parts.
class FreeFlight {
 public:
  static constexpr int kSubsteps = 8;

  /// `drag`: c, 1/s, >= 0; `gravity_W`: m/s^2.
  FreeFlight(double dt, double drag, const Vector3d& gravity_W);

  double dt() const { return dt_; }
  const Vector3d& gravity_W() const { return gravity_W_; }
  /// Returns the way (m) of a force's impulse at the start of the step over its acceleration, s^2.
  double Yield() const { return dt_ * held_; }
  /// Moves the body by one step.
  void Advance(const FreeBody& body, FreeMotion* motion) const;
  /// The same without gravity for a small motion q (m, rad) and its rate (m/s, rad/s).
  void AdvanceSmall(FreeBody::Motion* q, FreeBody::Motion* rate) const;
  /// Returns how much farther (m) gravity moves the centre in a step as an impulse at its start. With
  /// it a body at rest on contacts carries its weight exactly and keeps no velocity.
  Vector3d Impulse() const { return (dt_ * held_ - fallen_) * gravity_W_; }

 private:
  double dt_;
  double decay_;   // exp(-c dt)
  double held_;    // s: (1 - decay) / c
  double fallen_;  // s^2: (dt - held) / c
  Vector3d gravity_W_;
};

/// Turns the frame by a rotation vector (rad, world).
void TurnFrame(const Vector3d& rotation_W, Matrix3d* R_WF);

}  // namespace hpdm
