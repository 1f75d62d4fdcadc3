#include "engine/solver/free_body.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace hpdm {
namespace {

Matrix3d Cross(const Vector3d& a) {
  return (Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

// Returns the rotation by a rotation vector (rad).
Matrix3d RotationBy(const Vector3d& rotation) {
  const double angle = rotation.norm();
  if (!(angle > 0)) return Matrix3d::Identity();
  return Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
}

// Removes round-off from a rotation.
Matrix3d Orthonormal(const Matrix3d& R) {
  return Eigen::Quaterniond(R).normalized().toRotationMatrix();
}

}  // namespace

FreeBody::FreeBody(const Lattice& lattice, const Quadrature& tissue, double density) {
  const Eigen::Index n = lattice.size() - lattice.front_functions();
  const WeightMatrix weights = lattice.Weights(tissue.points);
  const Eigen::VectorXd dm = density * tissue.weights;
  const ScalarStiffness M(weights.transpose() * dm.asDiagonal() * weights);
  const Points p = lattice.ControlPoints().topRows(n);
  Eigen::VectorXd ones = Eigen::VectorXd::Zero(lattice.size());
  ones.head(n).setOnes();
  masses = (M * ones).head(n);
  mass = masses.sum();
  p_centre_W = p.transpose() * masses / mass;
  arms = p.rowwise() - p_centre_W.transpose();
  Points all = Points::Zero(lattice.size(), 3);
  all.topRows(n) = arms;
  moments = (M * all).topRows(n);
  const Matrix3d second = arms.transpose() * moments;
  inertia = second.trace() * Matrix3d::Identity() - (second + second.transpose()) / 2;
}

FreeBody::Motion FreeBody::RigidPart(const Points& W) const {
  Motion motion;
  Vector3d turned = Vector3d::Zero();
  for (Eigen::Index a = 0; a < masses.size(); ++a) {
    const Vector3d w = W.row(a);
    motion.translation += masses[a] * w;
    turned += Vector3d(moments.row(a)).cross(w);
  }
  motion.translation /= mass;
  motion.rotation = inertia.inverse() * turned;
  return motion;
}

void FreeBody::AddInertia(double yield, FullStiffness* K) const {
  const Matrix3d by_inertia = inertia.inverse() / yield;
  for (Eigen::Index a = 0; a < masses.size(); ++a) {
    const Matrix3d turned = Cross(moments.row(a)).transpose() * by_inertia;
    for (Eigen::Index b = 0; b < masses.size(); ++b) {
      Matrix3d block = turned * Cross(moments.row(b));
      block.diagonal().array() += masses[a] * masses[b] / (mass * yield);
      K->block<3, 3>(3 * a, 3 * b) += block;
    }
  }
}

FreeMotion MotionFrom(const FreeBody& body, const FreeBody::Motion& q,
                      const FreeBody::Motion& rate) {
  FreeMotion motion;
  const double slope = q.rotation.norm();  // of the points' ways, as tan of the best fit's angle
  const double share = slope > 0 ? std::atan(slope) / slope : 1;
  motion.R_WF = RotationBy(share * q.rotation);
  motion.p_W = body.p_centre_W + q.translation;
  motion.v_W = rate.translation;
  motion.momentum_W = motion.R_WF * (body.inertia * (motion.R_WF.transpose() * rate.rotation));
  return motion;
}

FreeFlight::FreeFlight(double dt, double drag, const Vector3d& gravity_W)
    : dt_(dt), decay_(std::exp(-drag * dt)), gravity_W_(gravity_W) {
  const double c_dt = drag * dt;
  // The series keep the digits that the differences lose: their next terms are below 1e-12.
  held_ = c_dt < 1e-4 ? dt * (1 - c_dt / 2 + c_dt * c_dt / 6) : -std::expm1(-c_dt) / drag;
  fallen_ = c_dt < 1e-4 ? dt * dt * (0.5 - c_dt / 6 + c_dt * c_dt / 24) : (dt - held_) / drag;
}

void FreeFlight::Advance(const FreeBody& body, FreeMotion* motion) const {
  motion->p_W += held_ * motion->v_W + fallen_ * gravity_W_;
  motion->v_W = decay_ * motion->v_W + held_ * gravity_W_;
  const Matrix3d inverse = body.inertia.inverse();
  Matrix3d& R = motion->R_WF;
  // The rotation of a decaying momentum is that of its mean over the step.
  const Vector3d mean_W = held_ / dt_ * motion->momentum_W;
  const auto omega_W = [&](const Matrix3d& at) {
    return Vector3d(at * (inverse * (at.transpose() * mean_W)));
  };
  const double part = dt_ / kSubsteps;
  for (int s = 0; s < kSubsteps && !mean_W.isZero(0); ++s) {
    const Matrix3d middle = RotationBy(part / 2 * omega_W(R)) * R;
    R = RotationBy(part * omega_W(middle)) * R;
  }
  R = Orthonormal(R);
  motion->momentum_W *= decay_;
}

void FreeFlight::AdvanceSmall(FreeBody::Motion* q, FreeBody::Motion* rate) const {
  q->translation += held_ * rate->translation;
  q->rotation += held_ * rate->rotation;
  rate->translation *= decay_;
  rate->rotation *= decay_;
}

void TurnFrame(const Vector3d& rotation_W, Matrix3d* R_WF) {
  *R_WF = Orthonormal(RotationBy(rotation_W) * *R_WF);
}

}  // namespace hpdm
