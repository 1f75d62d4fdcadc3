#include "engine/solver/free_body.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "engine/organ.h"
#include "tools/shared/simple_bodies.h"

namespace hpdm {
namespace {

constexpr double kPeriod = 1.0 / 30;  // s

OrganModel FreeOrgan(SurfaceMesh rest, double density) {
  OrganOptions options;
  options.name = "free";
  options.material.density = density;
  options.lattice.margin = 0.002;
  options.lattice.local.functions = 0;
  options.free.emplace();
  return {options, std::move(rest)};
}

// Moves a mesh into the world at a general pose.
SurfaceMesh Posed(SurfaceMesh mesh, const Isometry3d& X) {
  for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
    mesh.vertices.row(v) = X * Vector3d(mesh.vertices.row(v));
  }
  return mesh;
}

Isometry3d SomePose() {
  Isometry3d X = Isometry3d::Identity();
  X.rotate(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()));
  X.pretranslate(Vector3d(0.3, -0.2, 0.1));
  return X;
}

// The tissue's samples miss 1 % of the volume at a surface that lies aslant to the voxels.
TEST(FreeBody, HasTheMassAndInertiaOfABlock) {
  for (const double scale : {0.5, 2.0}) {
    const Vector3d sides = scale * Vector3d(0.1, 0.06, 0.04);
    for (const Isometry3d& X : {Isometry3d::Identity(), SomePose()}) {
      const OrganModel organ = FreeOrgan(Posed(GridBox(-sides / 2, sides / 2, {6, 4, 3}), X), 1060);
      const FreeBody& body = *organ.free_body();
      const double mass = 1060 * sides.prod();
      EXPECT_NEAR(body.mass / mass, 1, 0.01);
      EXPECT_LT((body.p_centre_W - X.translation()).norm(), 1e-3 * sides.norm());
      const Vector3d squares = sides.cwiseProduct(sides);
      const Vector3d about = mass / 12 * (squares.sum() - squares.array()).matrix();
      const Matrix3d inertia = X.linear() * about.asDiagonal() * X.linear().transpose();
      EXPECT_LT((body.inertia - inertia).norm(), 0.015 * inertia.norm());
    }
  }
}

TEST(FreeBody, HasTheMassAndInertiaOfASphere) {
  const double radius = 0.03, density = 900;
  const OrganModel organ = FreeOrgan(Ellipsoid(Vector3d::Constant(radius), 4), density);
  const FreeBody& body = *organ.free_body();
  const double mass = density * 4 / 3 * std::numbers::pi * std::pow(radius, 3);
  EXPECT_NEAR(body.mass / mass, 1, 0.01);
  const Matrix3d inertia = 0.4 * mass * radius * radius * Matrix3d::Identity();
  EXPECT_LT((body.inertia - inertia).norm(), 0.02 * inertia.norm());
}

// The closed form of a fall with linear drag.
TEST(FreeFlight, FollowsTheClosedFormAtAnyRate) {
  const OrganModel organ = FreeOrgan(Ellipsoid(Vector3d(0.03, 0.02, 0.01), 2), 1060);
  const FreeBody& body = *organ.free_body();
  const Vector3d g(0, 0, -9.81), v0(0.3, 0, 0.5);
  for (const double drag : {0.0, 1e-5, 0.5, 8.0}) {
    for (const double dt : {1.0 / 30, 1.0 / 250}) {
      FreeMotion motion;
      motion.v_W = v0;
      const FreeFlight flight(dt, drag, g);
      const int steps = static_cast<int>(std::lround(1 / dt));
      for (int k = 0; k < steps; ++k) flight.Advance(body, &motion);
      const double held = drag > 0 ? -std::expm1(-drag) / drag : 1;
      const double fallen = drag > 1e-3 ? (1 - held) / drag : 0.5 - drag / 6;
      EXPECT_LT((motion.p_W - (held * v0 + fallen * g)).norm(), 1e-8) << drag << ' ' << dt;
      EXPECT_LT((motion.v_W - (std::exp(-drag) * v0 + held * g)).norm(), 1e-8) << drag;
    }
  }
}

// An ellipsoid turns about its middle axis, which tumbles, for 10 s at a turn a second.
TEST(FreeFlight, KeepsAngularMomentumAndEnergyWithoutTorque) {
  const OrganModel organ = FreeOrgan(Ellipsoid(Vector3d(0.05, 0.03, 0.015), 3), 1060);
  const FreeBody& body = *organ.free_body();
  FreeMotion motion;
  const Vector3d omega = 2 * std::numbers::pi * Vector3d(0.02, 1, 0.01);
  motion.momentum_W = body.inertia * omega;
  const Vector3d before = motion.momentum_W;
  const auto energy = [&] {
    const Vector3d L = motion.R_WF.transpose() * motion.momentum_W;
    return 0.5 * L.dot(body.inertia.inverse() * L);
  };
  const double start = energy();
  const FreeFlight flight(kPeriod, 0, Vector3d::Zero());
  double tilt = 0;
  for (int k = 0; k < 300; ++k) {
    flight.Advance(body, &motion);
    EXPECT_NEAR(energy() / start, 1, 1e-3) << k;  // midpoint rule, 8 parts a step
    tilt = std::min(tilt, (motion.R_WF * Vector3d::UnitY()).dot(Vector3d::UnitY()));
  }
  EXPECT_EQ(motion.momentum_W, before);
  EXPECT_LT(tilt, -0.9);  // it has tumbled
  EXPECT_LT((motion.R_WF.transpose() * motion.R_WF - Matrix3d::Identity()).norm(), 1e-12);
}

TEST(FreeBody, ItsInertiaMovesAsABodyWhatItsRigidPartFinds) {
  const OrganModel organ =
      FreeOrgan(GridBox(Vector3d(0, 0, 0), Vector3d(0.1, 0.06, 0.04), {6, 4, 3}), 1060);
  const FreeBody& body = *organ.free_body();
  const Vector3d way(0.01, 0.02, -0.01), turn(0.1, -0.2, 0.3);
  Points W(body.arms.rows(), 3);
  for (Eigen::Index a = 0; a < W.rows(); ++a) {
    W.row(a) = way + turn.cross(Vector3d(body.arms.row(a)));
  }
  const FreeBody::Motion found = body.RigidPart(W);
  EXPECT_LT((found.translation - way).norm(), 1e-12);
  EXPECT_LT((found.rotation - turn).norm(), 1e-10);
  // Half of W^T (M / yield) W is the motion's energy over the yield.
  FullStiffness K = FullStiffness::Zero(W.size(), W.size());
  body.AddInertia(0.5, &K);
  const Eigen::Map<const Eigen::VectorXd> w(W.data(), W.size());
  const double twice = body.mass * way.squaredNorm() + turn.dot(body.inertia * turn);
  EXPECT_NEAR(w.dot(K * w), twice / 0.5, 1e-9 * twice);
}

}  // namespace
}  // namespace hpdm
