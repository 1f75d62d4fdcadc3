#include "engine/solver/relaxation.h"

#include <gtest/gtest.h>

#include "engine/tissue/support.h"

namespace hpdm {
namespace {

// A 0.2 x 0.15 x 0.1 m block held at its bottom, with a few contacts on its top.
class RelaxationTest : public testing::Test {
 protected:
  RelaxationTest() : contacts_(lattice_.size()), U_(Points::Zero(lattice_.size(), 3)) {}

  static OrientedBox Block() {
    return {Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.15, 0.1)};
  }
  static Quadrature Tissue() { return BoxQuadrature(Block(), {12, 12, 12}); }
  // The bottom fifth is held.
  static ScalarStiffness Supports(const Lattice& lattice, double modulus) {
    OrientedBox bottom = Block();
    bottom.lengths.z() *= 0.2;
    return SupportStiffness(lattice, Tissue(), {SupportOptions()},
                            {BoxQuadrature(bottom, {12, 12, 6})}, modulus);
  }
  static ScalarStiffness Stiffness(const Lattice& lattice) {
    return MetricStiffness(lattice, Tissue(), 2000, 0.05) + Supports(lattice, 2000);
  }

  void AddContact(ContactConstraints::RowKind kind, const Vector3d& p, const Vector3d& move) {
    ContactConstraints::Row* row = contacts_.Add();
    ASSERT_NE(row, nullptr);
    row->kind = kind;
    row->p_rest_W = p;
    row->target_W = p + move;
    contacts_.WeightRow(contacts_.size() - 1) = lattice_.Weights(p.transpose()).toDense().row(0);
  }
  Vector3d PositionOf(int i) const {
    return contacts_[i].p_rest_W + (contacts_.Weights().row(i) * U_).transpose();
  }

  Lattice lattice_{Block(), LatticeOptions()};
  ScalarStiffness K_ = Stiffness(lattice_);
  ContactConstraints contacts_;
  Points U_;
  std::unique_ptr<Relaxation> cholesky_ = MakeCholeskyRelaxation(K_);
  std::unique_ptr<Relaxation> gauss_seidel_ = MakeGaussSeidelRelaxation(K_, {.tolerance = 1e-9});
};

constexpr auto kGrasp = ContactConstraints::RowKind::kGrasp;
constexpr auto kPress = ContactConstraints::RowKind::kPress;

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

TEST_F(RelaxationTest, GaussSeidelAgreesWithCholesky) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kGrasp, Vector3d(0.06, 0.05, 0.1), Vector3d(0.01, 0, 0.015));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  cholesky_->Relax(&contacts_, &U_);
  const Points direct = U_;
  U_.setZero();
  const RelaxationResult result = gauss_seidel_->Relax(&contacts_, &U_);
  EXPECT_TRUE(result.converged) << result.residual;
  // Residual 1e-9 times the condition of K (about 1e4).
  EXPECT_LT((U_ - direct).norm(), 1e-5 * direct.norm());
}

TEST_F(RelaxationTest, ResultDoesNotDependOnTheMovedControlPoints) {
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  gauss_seidel_->Relax(&contacts_, &U_);
  const Points from_rest = U_;
  U_.setZero();
  const Points change = (contacts_[0].target_W - contacts_[0].p_rest_W).transpose();
  MoveDirectly(contacts_.Weights(), change, U_);
  gauss_seidel_->Relax(&contacts_, &U_);
  EXPECT_LT((U_ - from_rest).norm(), 1e-5 * from_rest.norm());
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
  for (int i = 0; i < kMaxContacts; ++i) {
    const Vector3d offset = 0.005 * Vector3d::Random();
    AddContact(kGrasp, Vector3d(0.1, 0.07, 0.09) + offset, Vector3d(0, 0, 0.02));
  }
  EXPECT_EQ(contacts_.Add(), nullptr);
  cholesky_->Relax(&contacts_, &U_);
  EXPECT_TRUE(U_.allFinite());
  // All points ask for the same lift, so it is reachable.
  for (int i = 0; i < kMaxContacts; ++i) {
    EXPECT_LT((PositionOf(i) - contacts_[i].target_W).norm(), 1e-4);
  }
  EXPECT_LT(U_.rowwise().norm().maxCoeff(), 0.1);
}

// The same block with the strain energy: stiff against volume change, coupled axes.
class StrainRelaxationTest : public RelaxationTest {
 protected:
  static FullStiffness StrainWithSupports(const Lattice& lattice) {
    FullStiffness K = StrainStiffness(lattice, Tissue(), {}, Dilatation::kProjected);
    AddAlongEachAxis(Supports(lattice, MaterialOptions().young), &K);
    return K;
  }
  Eigen::VectorXd Load() const {
    Points load = Points::Zero(lattice_.size(), 3);
    for (int i = 0; i < contacts_.size(); ++i) {
      load += contacts_.Weights().row(i).transpose() * contacts_[i].force_W.transpose();
    }
    return Eigen::Map<const Eigen::VectorXd>(load.data(), load.size());
  }

  FullStiffness K_full_ = StrainWithSupports(lattice_);
  std::unique_ptr<Relaxation> full_ = MakeCholeskyRelaxation(K_full_);
};

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

TEST_F(StrainRelaxationTest, GaussSeidelAgreesWithCholesky) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.02));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -0.01));
  full_->Relax(&contacts_, &U_);
  const Points direct = U_;
  U_.setZero();
  // At a Poisson's ratio of 0.45 the sweeps converge about five times more slowly than on the
  // metric energy.
  const auto gauss_seidel =
      MakeGaussSeidelRelaxation(K_full_, {.max_sweeps = 8000, .tolerance = 1e-7});
  const RelaxationResult result = gauss_seidel->Relax(&contacts_, &U_);
  EXPECT_TRUE(result.converged) << result.residual;
  // Residual 1e-7 times the condition of K (about 1e5), of which a load meets a part.
  EXPECT_LT((U_ - direct).norm(), 1e-4 * direct.norm());
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
