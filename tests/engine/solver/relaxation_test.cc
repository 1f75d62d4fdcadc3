#include "engine/solver/relaxation.h"

#include "tests/support/relaxation_fixture.h"

namespace hpdm {
namespace {

TEST_F(RelaxationTest, WithoutContactTheOrganIsAtRest) {
  for (Relaxation* relaxation : {cholesky_.get(), gauss_seidel_.get()}) {
    U_.setConstant(0.01);
    relaxation->Relax(&contacts_, &U_);
    EXPECT_EQ(U_.norm(), 0);
  }
}

TEST_F(RelaxationTest, GraspedPointsGoToTheirTargets) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kGrasp, Vector3d(0.15, 0.1, 0.1), Vector3d(0, -0.01, -0.005));
  for (Relaxation* relaxation : {cholesky_.get(), gauss_seidel_.get()}) {
    const RelaxationResult result = relaxation->Relax(&contacts_, &U_);
    EXPECT_TRUE(result.converged);
    for (int i = 0; i < 2; ++i) {
      // The pad compliance and the tolerance are both 1e-9 of the change.
      EXPECT_LT((PositionOf(i) - contacts_[i].target_W).norm(), 1e-9);
    }
  }
}

TEST_F(RelaxationTest, PressingNeverPulls) {
  // The second press asks the tissue to rise to it: it stays free, and the first is exact.
  AddContact(kPress, Vector3d(0.05, 0.05, 0.1), Vector3d(0, 0, -0.01));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, 0.01));
  for (Relaxation* relaxation : {cholesky_.get(), gauss_seidel_.get()}) {
    relaxation->Relax(&contacts_, &U_);
    EXPECT_NEAR(PositionOf(0).z(), 0.09, 1e-9);
    EXPECT_LT(contacts_[0].force_W.z(), 0);
    EXPECT_EQ(contacts_[0].force_W.head<2>().norm(), 0);  // frictionless
    EXPECT_EQ(contacts_[1].force_W.norm(), 0);
    EXPECT_LT(PositionOf(1).z(), 0.11);
  }
}

TEST_F(RelaxationTest, APressReleasedByItsNeighbourHasNoForce) {
  // A deep press beside a shallow one carries the tissue below the shallow one.
  AddContact(kPress, Vector3d(0.10, 0.07, 0.1), Vector3d(0, 0, -0.02));
  AddContact(kPress, Vector3d(0.11, 0.07, 0.1), Vector3d(0, 0, -0.001));
  for (Relaxation* relaxation : {cholesky_.get(), gauss_seidel_.get()}) {
    relaxation->Relax(&contacts_, &U_);
    EXPECT_EQ(contacts_[1].force_W.norm(), 0);
    EXPECT_LT(PositionOf(1).z(), contacts_[1].target_W.z());
  }
}

TEST_F(RelaxationTest, CoincidentContactsShareTheirForce) {
  for (const double apart : {0.0, 1e-12, 1e-6}) {
    contacts_.Clear();
    for (int i = 0; i < 4; ++i) {
      AddContact(kGrasp, Vector3d(0.05 + i * apart, 0.05, 0.1), Vector3d(0, 0, 0.01));
    }
    cholesky_->Relax(&contacts_, &U_);
    Vector3d total = Vector3d::Zero();
    for (int i = 0; i < 4; ++i) {
      EXPECT_NEAR(PositionOf(i).z(), 0.11, 1e-7);
      total += contacts_[i].force_W;
    }
    contacts_.Clear();
    AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0, 0, 0.01));
    cholesky_->Relax(&contacts_, &U_);
    // Points 1e-6 m apart that rise alike also hold the surface's slope there, which costs 1.4 %.
    EXPECT_NEAR(total.z() / contacts_[0].force_W.z(), 1, 0.02);
  }
}

TEST_F(RelaxationTest, CoincidentContactsThatArePulledApartSlip) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.05, 0, 0));
  cholesky_->Relax(&contacts_, &U_);
  const double alone = contacts_[0].force_W.norm(), moved = U_.rowwise().norm().maxCoeff();
  for (const double apart : {0.0, 1e-12, 1e-6, 1e-3}) {
    contacts_.Clear();
    AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.05, 0, 0));
    AddContact(kGrasp, Vector3d(0.05 + apart, 0.05, 0.1), Vector3d(-0.05, 0, 0));
    const RelaxationResult result = cholesky_->Relax(&contacts_, &U_);
    EXPECT_TRUE(result.regularised);
    for (int i = 0; i < 2; ++i) {
      EXPECT_LT(contacts_[i].force_W.norm(), 11 * alone) << "the bound, and their own places'";
      // Step and tick agree on the tool's position, to the round-off of 0.1 m.
      const Vector3d p_tool = PositionOf(i) + contacts_[i].slip * contacts_[i].force_W;
      EXPECT_LT((p_tool - contacts_[i].target_W).norm(), 1e-9);
    }
    EXPECT_LT(U_.rowwise().norm().maxCoeff(), 2 * moved) << "most of it cancels";
  }
}

TEST_F(RelaxationTest, ThirtyTwoGraspedPointsInACentimetreStayFinite) {
  srand(1);
  for (int i = 0; i < kMaxToolRows; ++i) {
    const Vector3d offset = 0.005 * Vector3d::Random();
    AddContact(kGrasp, Vector3d(0.1, 0.07, 0.09) + offset, Vector3d(0, 0, 0.02));
  }
  EXPECT_EQ(contacts_.Add(), nullptr);
  cholesky_->Relax(&contacts_, &U_);
  EXPECT_TRUE(U_.allFinite());
  // All points ask for the same lift, so it is reachable.
  for (int i = 0; i < kMaxToolRows; ++i) {
    EXPECT_LT((PositionOf(i) - contacts_[i].target_W).norm(), 1e-4);
  }
  EXPECT_LT(U_.rowwise().norm().maxCoeff(), 0.1);
}

}  // namespace
}  // namespace hpdm
