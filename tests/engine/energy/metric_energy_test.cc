#include "engine/energy/metric_energy.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include "tests/support/shapes.h"

namespace hpdm {
namespace {

Lattice SomeLattice(BasisType type, int degree) {
  LatticeOptions options;
  options.basis = type;
  options.degree = {degree, degree, degree};
  options.cells = {4, 3, 5};
  return Lattice({SomePose().translation(), SomePose().linear(), Vector3d(0.2, 0.15, 0.1)},
                 options);
}

std::vector<Lattice> BuiltLattices() {
  return {SomeLattice(BasisType::kBSpline, 1), SomeLattice(BasisType::kBSpline, 2),
          SomeLattice(BasisType::kBSpline, 3), SomeLattice(BasisType::kBernstein, 3)};
}

Quadrature WholeBox(const Lattice& lattice) { return BoxQuadrature(lattice.box(), {12, 12, 15}); }

TEST(MetricEnergy, StiffnessIsSymmetricSemiDefiniteWithZeroRowSums) {
  for (const Lattice& lattice : BuiltLattices()) {
    const Eigen::MatrixXd K = MetricStiffness(lattice, WholeBox(lattice), 2000, 0.05);
    const double size = K.cwiseAbs().maxCoeff();
    EXPECT_EQ((K - K.transpose()).cwiseAbs().maxCoeff(), 0);
    EXPECT_LT(K.rowwise().sum().cwiseAbs().maxCoeff(), 1e-12 * size);  // round-off
    const Eigen::VectorXd eigenvalues =
        Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(K).eigenvalues();
    EXPECT_GT(eigenvalues[0], -1e-12 * size);  // round-off below zero
    EXPECT_GT(eigenvalues[1], 1e-9 * size);    // one zero mode only: translation
  }
}

TEST(MetricEnergy, TranslationCostsNothing) {
  for (const Lattice& lattice : BuiltLattices()) {
    const ScalarStiffness K = MetricStiffness(lattice, WholeBox(lattice), 2000, 0.05);
    const Points U = Eigen::RowVector3d(0.03, -0.02, 0.01).replicate(lattice.size(), 1);
    const double size = Eigen::MatrixXd(K).cwiseAbs().maxCoeff();
    EXPECT_NEAR((U.transpose() * (K * U)).trace(), 0, 1e-14 * size);
  }
}

TEST(MetricEnergy, UniformStretchCostsAlphaTimesStrainSquaredTimesVolume) {
  const double alpha = 2000, strain = 0.01;
  for (const Lattice& lattice : BuiltLattices()) {
    const ScalarStiffness K = MetricStiffness(lattice, WholeBox(lattice), alpha, 0.05);
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3d direction = lattice.box().axes.col(axis);
      const Points U = strain * (lattice.ControlPoints() * direction) * direction.transpose();
      const double energy = 0.5 * (U.transpose() * (K * U)).trace();
      // The difference weights add up to the volume exactly, and second differences vanish.
      EXPECT_NEAR(energy, 0.5 * alpha * strain * strain * lattice.box().Volume(), 1e-12);
    }
  }
}

TEST(MetricEnergy, GradientAgreesWithFiniteDifference) {
  const Lattice lattice = SomeLattice(BasisType::kBSpline, 2);
  const ScalarStiffness K = MetricStiffness(lattice, WholeBox(lattice), 2000, 0.05);
  const auto energy = [&](const Points& U) { return 0.5 * (U.transpose() * (K * U)).trace(); };
  srand(1);
  const Points U = Points::Random(lattice.size(), 3) * 0.01;
  const Points direction = Points::Random(lattice.size(), 3);
  const double step = 1e-3;  // exact for a quadratic whatever the step, so no truncation error
  const double difference =
      (energy(U + step * direction) - energy(U - step * direction)) / (2 * step);
  EXPECT_NEAR((direction.transpose() * (K * U)).trace() / difference, 1, 1e-9);
}

TEST(MetricEnergy, BodyRescaledByAThousandHasTheScaledStiffness) {
  LatticeOptions options;
  const OrientedBox small{Vector3d::Zero(), Matrix3d::Identity(), Vector3d(0.2, 0.15, 0.1)};
  OrientedBox large = small;
  large.lengths *= 1000;
  const auto stiffness = [&](const OrientedBox& box, double beta) {
    const Lattice lattice(box, options);
    return Eigen::MatrixXd(MetricStiffness(lattice, BoxQuadrature(box, {12, 12, 12}), 2000, beta));
  };
  // alpha L; beta / L, with beta scaled by L^2 to keep the ratio.
  const Eigen::MatrixXd K = stiffness(small, 0.05);
  EXPECT_LT((stiffness(large, 0.05e6) / 1000 - K).norm(), 1e-12 * K.norm());
}

TEST(MetricEnergy, RotationCostsEnergy) {
  // The paper's linear model is not rotation-invariant: a quarter turn costs as much as a large
  // strain. The test documents this limit.
  const Lattice lattice = SomeLattice(BasisType::kBSpline, 2);
  const ScalarStiffness K = MetricStiffness(lattice, WholeBox(lattice), 1, 0);
  const Matrix3d R = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitZ()).toRotationMatrix();
  const Points P = lattice.ControlPoints();
  const Points U = P * R.transpose() - P;
  // |R - I|^2 / 2 = 2 for a quarter turn.
  EXPECT_NEAR(0.5 * (U.transpose() * (K * U)).trace() / lattice.box().Volume(), 2, 1e-9);
}

}  // namespace
}  // namespace hpdm
