// The iterative solver agrees with the direct one.

#include "tests/support/relaxation_fixture.h"

namespace hpdm {
namespace {

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

}  // namespace
}  // namespace hpdm
