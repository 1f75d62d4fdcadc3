#include "engine/energy/hyperelastic.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <vector>

namespace hpdm {
namespace {

constexpr MaterialLaw kBothLaws[] = {MaterialLaw::kNeoHookean, MaterialLaw::kStVenantKirchhoff};

LameParameters Lame(double poisson = 0.45) { return ToLame({.young = 5000, .poisson = poisson}); }

// Moderate deformations of either handedness, and collapse to a plane, a line and a point.
std::vector<Matrix3d> Deformations() {
  srand(1);
  std::vector<Matrix3d> all;
  for (int i = 0; i < 5; ++i) {
    all.push_back(Matrix3d::Identity() + 0.3 * Matrix3d::Random());
    all.push_back(-all.back());
  }
  all.push_back(Vector3d(1, 1, 0).asDiagonal());
  all.push_back(Vector3d(1, 0, 0).asDiagonal());
  all.push_back(Matrix3d::Zero());
  return all;
}

TEST(Hyperelastic, StressIsTheGradientOfTheEnergyAndTangentThatOfTheStress) {
  constexpr double kStep = 1e-5;
  for (const MaterialLaw type : kBothLaws) {
    const HyperelasticLaw law(type, Lame());
    for (const Matrix3d& F : Deformations()) {
      const Matrix3d P = law.Stress(F);
      const Matrix9d A = law.Tangent(F);
      for (int i = 0; i < 9; ++i) {
        Matrix3d ahead = F, behind = F;
        ahead.data()[i] += kStep;
        behind.data()[i] -= kStep;
        // Central differences err by 1e-10 of the third derivative, about 10 times the modulus (1e5
        // Pa), and by the round-off 1e-16 / 1e-5 of it.
        EXPECT_NEAR(P.data()[i], (law.Energy(ahead) - law.Energy(behind)) / (2 * kStep), 1e-3);
        const Matrix3d difference = (law.Stress(ahead) - law.Stress(behind)) / (2 * kStep);
        EXPECT_LT((A.col(i) - difference.reshaped()).norm(), 1e-3);
      }
      EXPECT_LE((A - A.transpose()).norm(), 1e-12 * A.norm());
    }
  }
}

TEST(Hyperelastic, RotationsAreFreeAndNothingElseIs) {
  srand(2);
  for (const MaterialLaw type : kBothLaws) {
    for (const double poisson : {0.0, 0.3, 0.45, 0.495}) {
      const HyperelasticLaw law(type, Lame(poisson));
      for (int i = 0; i < 10; ++i) {
        const Matrix3d R = Eigen::Quaterniond::UnitRandom().toRotationMatrix();
        EXPECT_NEAR(law.Energy(R), 0, 1e-9);  // Pa; the moduli are 1e3 to 2e5
        EXPECT_LT(law.Stress(R).norm(), 1e-9);
        const Matrix3d F = Matrix3d::Identity() + 0.2 * Matrix3d::Random();
        EXPECT_GT(law.Energy(F), 0);
        EXPECT_NEAR(law.Energy(R * F) / law.Energy(F), 1, 1e-9);
        EXPECT_NEAR(law.Energy(F * R) / law.Energy(F), 1, 1e-9);  // isotropic
      }
    }
  }
}

TEST(Hyperelastic, SmallStrainIsLinearElasticity) {
  for (const MaterialLaw type : kBothLaws) {
    const LameParameters lame = Lame();
    const Matrix9d A = HyperelasticLaw(type, lame).Tangent(Matrix3d::Identity());
    for (int i = 0; i < 9; ++i) {
      Matrix3d u = Matrix3d::Zero();
      u.data()[i] = 1;
      const Matrix3d strain = (u + u.transpose()) / 2;
      const Matrix3d stress =
          2 * lame.mu * strain + lame.lambda * strain.trace() * Matrix3d::Identity();
      EXPECT_LT((A.col(i) - stress.reshaped()).norm(), 1e-11 * A.norm());
    }
  }
}

TEST(Hyperelastic, NeoHookeanPullsCollapsedAndInvertedTissueBack) {
  const HyperelasticLaw law(MaterialLaw::kNeoHookean, Lame());
  // Flattened along z, from full size through a plane to its mirror image: all the way the energy
  // rises and the stress pushes z back up.
  double last = -1;
  for (double z = 1; z >= -1; z -= 0.05) {
    const Matrix3d F = Vector3d(1, 1, z).asDiagonal();
    EXPECT_GT(law.Energy(F), last);
    last = law.Energy(F);
    // z = 1 itself has no stress.
    EXPECT_LT(law.Stress(F)(2, 2), z < 0.99 ? 0 : 1e-9);
  }
}

TEST(Hyperelastic, ProjectionKeepsTheConvexPart) {
  const HyperelasticLaw law(MaterialLaw::kNeoHookean, Lame());
  for (const Matrix3d& F : Deformations()) {
    const Matrix9d A = law.Tangent(F), projected = ProjectedToSemiDefinite(A);
    const Eigen::SelfAdjointEigenSolver<Matrix9d> before(A), after(projected);
    EXPECT_GE(after.eigenvalues()[0], -1e-10 * A.norm());
    EXPECT_NEAR(after.eigenvalues()[8], std::max(before.eigenvalues()[8], 0.0), 1e-10 * A.norm());
  }
}

}  // namespace
}  // namespace hpdm
