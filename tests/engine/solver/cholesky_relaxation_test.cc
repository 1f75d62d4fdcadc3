// The direct solver balances forces and keeps no memory of earlier contacts.

#include "tests/support/relaxation_fixture.h"

namespace hpdm {
namespace {

TEST_F(RelaxationTest, ForcesBalanceTheEnergysGradient) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  cholesky_->Relax(&contacts_, &U_);
  Points load = Points::Zero(lattice_.size(), 3);
  for (int i = 0; i < 2; ++i) {
    load += contacts_.Weights().row(i).transpose() * contacts_[i].force_W.transpose();
  }
  EXPECT_LT((K_ * U_ - load).norm(), 1e-10 * load.norm());
}

TEST_F(StrainRelaxationTest, ForcesBalanceTheEnergysGradient) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  AddContact(kPress, Vector3d(0.12, 0.03, 0.1), Vector3d(0, 0, 0.01));
  EXPECT_TRUE(full_->Relax(&contacts_, &U_).converged);
  // Round-off of K^-1, whose condition is about 1e5.
  const Eigen::Map<const Eigen::VectorXd> u(U_.data(), U_.size());
  EXPECT_LT((K_full_ * u - Load()).norm(), 1e-9 * Load().norm());
  EXPECT_LT((PositionOf(0) - contacts_[0].target_W).norm(), 1e-9);
  EXPECT_NEAR(PositionOf(1).z(), 0.09, 1e-9);
  EXPECT_LT(contacts_[1].force_W.z(), 0);
  EXPECT_EQ(contacts_[2].force_W.norm(), 0);
}

TEST_F(StrainRelaxationTest, EarlierContactsLeaveNoTrace) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  full_->Relax(&contacts_, &U_);
  contacts_.Clear();
  AddContact(kPress, Vector3d(0.12, 0.03, 0.1), Vector3d(0, 0, -0.01));
  full_->Relax(&contacts_, &U_);
  const Points after = U_;
  MakeCholeskyRelaxation(K_full_)->Relax(&contacts_, &U_);
  EXPECT_TRUE(U_ == after);
}

TEST_F(StrainRelaxationTest, UncoupledAxesGiveTheScalarSolution) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  cholesky_->Relax(&contacts_, &U_);
  const Points scalar = U_;
  FullStiffness K = FullStiffness::Zero(3 * lattice_.size(), 3 * lattice_.size());
  AddAlongEachAxis(K_, &K);
  MakeCholeskyRelaxation(K)->Relax(&contacts_, &U_);
  EXPECT_LT((U_ - scalar).norm(), 1e-9 * scalar.norm());  // round-off of K^-1
}

}  // namespace
}  // namespace hpdm
