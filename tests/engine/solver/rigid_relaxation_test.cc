// A rigid organ answers each contact alone, by a virtual wall in closed form.

#include <gtest/gtest.h>

#include "engine/solver/relaxation.h"

namespace hpdm {
namespace {

constexpr double kWall = 300;  // N/m
constexpr double kPad = 1e-8;  // relative: the contacts' pad is 1e-9 of their compliance

class RigidRelaxationTest : public testing::Test {
 protected:
  ContactConstraints::Row& Add(ContactConstraints::RowKind kind, const Vector3d& move) {
    ContactConstraints::Row& row = *contacts_.Add();
    row.kind = kind;
    row.target_W = move;
    row.local_compliance_W = Matrix3d::Identity() / kWall;
    return row;
  }

  ContactConstraints contacts_{0};
  Points U_ = Points::Zero(0, 3);
  std::unique_ptr<Relaxation> relaxation_ = MakeRigidRelaxation();
};

TEST_F(RigidRelaxationTest, APressGetsStiffnessTimesDepthOfTheWallAlone) {
  const auto& pressed = Add(ContactConstraints::RowKind::kPress, Vector3d(0, 0, -0.004));
  const auto& free = Add(ContactConstraints::RowKind::kPress, Vector3d(0, 0, 0.001));
  auto& sliding = Add(ContactConstraints::RowKind::kPress, Vector3d(0, 0, -0.002));
  sliding.friction_W = Vector3d(0.3, 0, 0);
  EXPECT_TRUE(relaxation_->Relax(&contacts_, &U_).converged);
  EXPECT_LT((pressed.force_W - Vector3d(0, 0, -kWall * 0.004)).norm(), kPad);
  EXPECT_EQ(free.force_W, Vector3d::Zero());
  EXPECT_LT((sliding.force_W - kWall * 0.002 * Vector3d(0.3, 0, -1)).norm(), kPad);
}

TEST_F(RigidRelaxationTest, AGraspIsPulledBackByTheWallsStiffness) {
  const Vector3d move(0.003, -0.001, 0.002);
  const auto& row = Add(ContactConstraints::RowKind::kGrasp, move);
  EXPECT_TRUE(relaxation_->Relax(&contacts_, &U_).converged);
  EXPECT_LT((row.force_W - kWall * move).norm(), kPad);
}

TEST_F(RigidRelaxationTest, NothingYieldsBesideAContact) {
  EXPECT_EQ(relaxation_->compliance()->PointCompliance({}), Matrix3d::Zero());
  EXPECT_TRUE(relaxation_->AtRest());
  EXPECT_TRUE(relaxation_->Relax(&contacts_, &U_).converged) << "no contact";
}

}  // namespace
}  // namespace hpdm
