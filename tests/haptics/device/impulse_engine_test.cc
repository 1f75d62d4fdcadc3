#include "haptics/device/impulse_engine.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "engine/base/error.h"
#include "haptics/device/hand_script.h"

namespace hpdm {
namespace {

const Vector3d kTrocar(0.1, -0.2, 0.3);

std::vector<Vector3d> HomeDirections() {
  std::vector<Vector3d> directions;
  for (int axis = 0; axis < 3; ++axis) {
    directions.push_back(Vector3d::Unit(axis));
    directions.push_back(-Vector3d::Unit(axis));
  }
  directions.push_back({1, 1, 1});
  directions.push_back({0.3, -2, 0.7});
  return directions;
}

ImpulseEngineKinematics Kinematics(const Vector3d& home) {
  return {kTrocar, home, DeviceProfile{}};
}

JointVector RandomJoints(HandRandom* random) {
  const DeviceLimits limits = LimitsOf(DeviceProfile{});
  JointVector joints;
  for (int i = 0; i < joints.size(); ++i) {
    joints[i] = random->Uniform(limits.min_joints[i], limits.max_joints[i]);
  }
  return joints;
}

TEST(ImpulseEngine, InverseUndoesForwardOverTheWorkspace) {
  HandRandom random(1);
  for (const Vector3d& home : HomeDirections()) {
    const ImpulseEngineKinematics kinematics = Kinematics(home);
    for (int i = 0; i < 500; ++i) {
      const JointVector joints = RandomJoints(&random);
      const auto inverse =
          kinematics.Inverse(kinematics.Forward(joints).translation(), joints[kRoll], joints[kJaw]);
      // Round-off of coordinates of 0.5 m over an insertion of 0.02 m or more: 1e-14 rad.
      EXPECT_LT((inverse.joints - joints).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(ImpulseEngine, ShaftPassesThroughTheTrocarAndFramesAreRigid) {
  HandRandom random(2);
  for (const Vector3d& home : HomeDirections()) {
    const ImpulseEngineKinematics kinematics = Kinematics(home);
    for (int i = 0; i < 50; ++i) {
      const JointVector joints = RandomJoints(&random);
      const Isometry3d X_WT = kinematics.Forward(joints);
      EXPECT_LT((X_WT * Vector3d(0, 0, joints[kInsertion]) - kTrocar).norm(), 1e-14);
      EXPECT_LT((X_WT.linear().transpose() * X_WT.linear() - Matrix3d::Identity()).norm(), 1e-14);
      EXPECT_NEAR(X_WT.linear().determinant(), 1, 1e-14);
    }
    JointVector zero = JointVector::Zero();
    zero[kInsertion] = 0.1;
    EXPECT_LT((kinematics.Forward(zero).translation() - kTrocar - 0.1 * home.normalized()).norm(),
              1e-15);
  }
}

TEST(ImpulseEngine, RollTurnsTheJawsAxisAboutTheShaftOnly) {
  const ImpulseEngineKinematics kinematics = Kinematics({0.3, -2, 0.7});
  JointVector joints;
  joints << 0.4, -0.3, 0.12, 0, 1;
  const Isometry3d before = kinematics.Forward(joints);
  joints[kRoll] = 0.7;
  const Isometry3d after = kinematics.Forward(joints);
  EXPECT_LT((after.translation() - before.translation()).norm(), 1e-15);
  const Vector3d turned = Eigen::AngleAxisd(0.7, before.linear().col(2)) * before.linear().col(1);
  EXPECT_LT((after.linear().col(1) - turned).norm(), 1e-14);
}

TEST(ImpulseEngine, JacobianIsTheDerivativeOfTheTip) {
  HandRandom random(3);
  for (const Vector3d& home : HomeDirections()) {
    const ImpulseEngineKinematics kinematics = Kinematics(home);
    const JointVector joints = RandomJoints(&random);
    const Matrix3d J = kinematics.Jacobian(joints);
    for (int axis = 0; axis < 3; ++axis) {
      const double h = 1e-5;
      JointVector more = joints, less = joints;
      more[axis] += h;
      less[axis] -= h;
      const Vector3d difference =
          (kinematics.Forward(more).translation() - kinematics.Forward(less).translation()) /
          (2 * h);
      // Truncation h^2/6 * 0.3 m = 5e-12 and round-off 1e-16 / h = 1e-11.
      EXPECT_LT((J.col(axis) - difference).norm(), 1e-10);
    }
  }
}

// The device's sub-step and the absence of a singularity rest on these.
TEST(ImpulseEngine, JacobianHasOrthogonalColumnsAndNoSingularityInTheWorkspace) {
  HandRandom random(4);
  const ImpulseEngineKinematics kinematics = Kinematics({1, 1, 1});
  for (int i = 0; i < 500; ++i) {
    const JointVector joints = RandomJoints(&random);
    const Matrix3d J = kinematics.Jacobian(joints);
    const double rho = joints[kInsertion], c = std::cos(joints[kPitch]);
    const Matrix3d expected = Vector3d(rho * rho, rho * rho * c * c, 1).asDiagonal();
    EXPECT_LT((J.transpose() * J - expected).norm(), 1e-15);
    EXPECT_NEAR(std::abs(J.determinant()), rho * rho * c, 1e-15);
  }
}

TEST(ImpulseEngine, EffortsDoTheWorkOfTheForce) {
  HandRandom random(5);
  const ImpulseEngineKinematics kinematics = Kinematics({0.3, -2, 0.7});
  for (int i = 0; i < 100; ++i) {
    const JointVector joints = RandomJoints(&random);
    const Vector3d force(random.Uniform(-5, 5), random.Uniform(-5, 5), random.Uniform(-5, 5));
    const AxisEffort effort = kinematics.Jacobian(joints).transpose() * force;
    const double h = 1e-6;
    const Vector3d dq =
        h * Vector3d(random.Uniform(-1, 1), random.Uniform(-1, 1), random.Uniform(-1, 1));
    JointVector more = joints, less = joints;
    more.head<3>() += dq / 2;
    less.head<3>() -= dq / 2;
    const double work =
        force.dot(kinematics.Forward(more).translation() - kinematics.Forward(less).translation());
    // Round-off of positions, 1e-16 m, times 5 N.
    EXPECT_NEAR(effort.dot(dq), work, 5e-15);
  }
}

TEST(ImpulseEngine, OutsideTheWorkspaceJointsAreClampedAndReported) {
  const ImpulseEngineKinematics kinematics = Kinematics({0, 0, -1});
  const DeviceLimits limits = kinematics.limits();
  const auto far = kinematics.Inverse(kTrocar + Vector3d(0, 0, -1), 0, 0.5);
  EXPECT_FALSE(far.reachable);
  EXPECT_EQ(far.joints[kInsertion], limits.max_joints[kInsertion]);
  const auto behind = kinematics.Inverse(kTrocar + Vector3d(0.01, 0.1, 0.1), 0, 0.5);
  EXPECT_FALSE(behind.reachable);
  EXPECT_TRUE((behind.joints.array() <= limits.max_joints.array()).all());
  EXPECT_TRUE((behind.joints.array() >= limits.min_joints.array()).all());
  const auto at_trocar = kinematics.Inverse(kTrocar, 0, 0.5);
  EXPECT_FALSE(at_trocar.reachable);
  EXPECT_EQ(at_trocar.joints[kPitch], 0);
  EXPECT_EQ(at_trocar.joints[kYaw], 0);
  EXPECT_EQ(at_trocar.joints[kInsertion], limits.min_joints[kInsertion]);
  EXPECT_TRUE(kinematics.Inverse(kTrocar + Vector3d(0, 0, -0.1), 0, 0.5).reachable);
}

TEST(ImpulseEngine, EncodersRoundToWholeSteps) {
  HandRandom random(6);
  const ImpulseEngineKinematics kinematics = Kinematics({0, 0, -1});
  const JointVector steps = kinematics.limits().encoder_steps;
  for (int i = 0; i < 100; ++i) {
    const JointVector joints = RandomJoints(&random);
    const JointVector quantised = kinematics.Quantise(joints);
    // Half a step, and round-off of the division.
    EXPECT_TRUE(((quantised - joints).array().abs() <= 0.5000001 * steps.array()).all());
    const JointVector counts = quantised.cwiseQuotient(steps);
    EXPECT_LT((counts - counts.array().round().matrix()).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_EQ(kinematics.Quantise(quantised), quantised);
  }
}

TEST(ImpulseEngine, RefusesAWorkspaceWithASingularity) {
  EXPECT_THROW(Kinematics({0, 0, 0}), InputError);
  DeviceProfile profile;
  profile.max_angle = std::numbers::pi / 2;
  EXPECT_THROW(ImpulseEngineKinematics(kTrocar, {0, 0, 1}, profile), InputError);
  profile = {};
  profile.min_insertion = 0;
  EXPECT_THROW(ImpulseEngineKinematics(kTrocar, {0, 0, 1}, profile), InputError);
}

}  // namespace
}  // namespace hpdm
