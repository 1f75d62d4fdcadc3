#include "engine/solver/elastic_relaxation.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <memory>
#include <vector>

#include "engine/contact/half_space.h"
#include "engine/energy/finite_metric_energy.h"
#include "engine/energy/finite_strain_energy.h"
#include "engine/energy/hyperelastic.h"
#include "engine/organ/organ_state.h"
#include "tests/support/relaxation_fixture.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

struct StrainCase {
  MaterialLaw law;
  Dilatation dilatation;
};
constexpr StrainCase kStrainCases[] = {{MaterialLaw::kNeoHookean, Dilatation::kProjected},
                                       {MaterialLaw::kNeoHookean, Dilatation::kPointwise},
                                       {MaterialLaw::kStVenantKirchhoff, Dilatation::kProjected},
                                       {MaterialLaw::kStVenantKirchhoff, Dilatation::kPointwise}};
constexpr StrainCase kNeoHookean = kStrainCases[0];

// The block of 4 x 4 x 4 quadratic cells, its bottom fifth held.
class ElasticRelaxationTest : public ContactBlockTest {
 protected:
  ScalarStiffness SupportsOrNone(bool supported) const {
    return supported ? supports_ : ScalarStiffness(lattice_.size(), lattice_.size());
  }
  FiniteStrainEnergy Strain(const StrainCase& kind, bool supported = true) const {
    return {lattice_, tissue_, kind.law, ToLame({}), kind.dilatation, SupportsOrNone(supported)};
  }
  FiniteMetricEnergy Metric(bool supported = true) const {
    return {lattice_, tissue_, 500, 0.05, SupportsOrNone(supported)};
  }
  std::vector<std::unique_ptr<ElasticEnergy>> All(bool supported) const {
    std::vector<std::unique_ptr<ElasticEnergy>> all;
    for (const StrainCase& kind : kStrainCases) all.push_back(Strain(kind, supported).Clone());
    all.push_back(Metric(supported).Clone());
    return all;
  }
  // Control displacements of the linear map x -> F x, which the Greville points reproduce.
  Points LinearMap(const Matrix3d& F) const {
    return lattice_.ControlPoints() * (F - Matrix3d::Identity()).transpose();
  }
  Points Shaken(double size) const {
    srand(1);
    return size * Points::Random(lattice_.size(), 3);
  }

  // Cell by cell, as SampleTissue gives it.
  Quadrature tissue_ = CellByCell(lattice_.box());
  ScalarStiffness supports_ = Supports(lattice_, tissue_, MaterialOptions().young);

 private:
  static Quadrature CellByCell(const OrientedBox& box) {
    Quadrature all{Points(64 * 27, 3), Eigen::VectorXd(64 * 27)};
    for (int c = 0; c < 64; ++c) {
      OrientedBox cell = box;
      cell.lengths /= 4;
      cell.origin_W = box.FromUnit(Eigen::Vector3i(c / 16, c / 4 % 4, c % 4).cast<double>() / 4);
      const Quadrature part = BoxQuadrature(cell, {3, 3, 3});
      all.points.middleRows(27 * c, 27) = part.points;
      all.weights.segment(27 * c, 27) = part.weights;
    }
    return all;
  }
};

TEST_F(ElasticRelaxationTest, GradientAndHessianAreDerivativesOfTheEnergy) {
  for (const auto& energy : All(true)) {
    const Points U = Shaken(0.01), direction = Shaken(1).rowwise().reverse();
    Points gradient = U, ahead = U, behind = U;
    const double value = energy->Gradient(U, &gradient);
    EXPECT_NEAR(energy->Energy(U) / value, 1, 1e-14);
    FullStiffness K;
    energy->Hessian(U, false, &K);
    EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
    // Errors: 1e-12 of the third derivative along the unit step, 1e-16 / 1e-6 of round-off.
    constexpr double kStep = 1e-6;
    const double up = energy->Gradient(U + kStep * direction, &ahead);
    const double down = energy->Gradient(U - kStep * direction, &behind);
    EXPECT_NEAR((up - down) / (2 * kStep) / gradient.cwiseProduct(direction).sum(), 1, 1e-6);
    const Points difference = (ahead - behind) / (2 * kStep);
    const Eigen::VectorXd product =
        K * Eigen::Map<const Eigen::VectorXd>(direction.data(), direction.size());
    EXPECT_LT(
        (product - Eigen::Map<const Eigen::VectorXd>(difference.data(), difference.size())).norm(),
        1e-6 * product.norm());
  }
}

TEST_F(ElasticRelaxationTest, SemiDefiniteHessianHasNoNegativeCurvature) {
  for (const auto& energy : All(true)) {
    // Points thrown by a cell's size turn tissue inside out.
    FullStiffness K, positive;
    energy->Hessian(Shaken(0.03), false, &K);
    energy->Hessian(Shaken(0.03), true, &positive);
    const Eigen::SelfAdjointEigenSolver<FullStiffness> before(K, Eigen::EigenvaluesOnly);
    const Eigen::SelfAdjointEigenSolver<FullStiffness> after(positive, Eigen::EigenvaluesOnly);
    EXPECT_LT(before.eigenvalues()[0], 0);
    EXPECT_GE(after.eigenvalues()[0], -1e-12 * positive.norm());  // round-off
    // A semi-definite Hessian stays unchanged.
    energy->Hessian(Points::Zero(lattice_.size(), 3), false, &K);
    energy->Hessian(Points::Zero(lattice_.size(), 3), true, &positive);
    EXPECT_LT((K - positive).norm(), 1e-12 * K.norm());
  }
}

TEST_F(ElasticRelaxationTest, FiniteRotationsCostNothing) {
  const Matrix3d R = Eigen::AngleAxisd(2.1, Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  const Points X = lattice_.ControlPoints();
  for (const auto& energy : All(false)) {
    Points turned = X * R.transpose();
    turned.rowwise() += Eigen::RowVector3d(0.3, -0.1, 0.2);
    Points gradient = X;
    const double scale = energy->Energy(Shaken(0.01));
    EXPECT_LT(std::abs(energy->Gradient(turned - X, &gradient)), 1e-9 * scale);
    EXPECT_LT(gradient.norm() * 0.01, 1e-9 * scale);
    // A deformed body that is turned as well has the same energy.
    const Points deformed = X + Shaken(0.01);
    EXPECT_NEAR(energy->Energy(deformed * R.transpose() - X) / energy->Energy(deformed - X), 1,
                1e-9);
  }
}

TEST_F(ElasticRelaxationTest, LinearMapsPassThePatchTest) {
  Matrix3d F;
  F << 1.2, 0.3, -0.1, -0.2, 0.9, 0.15, 0.05, -0.25, 1.1;
  for (const auto& energy : All(false)) {
    Points gradient = U_;
    energy->Gradient(LinearMap(F), &gradient);
    double inner = 0;
    for (int i = 2; i <= 3; ++i) {  // functions that vanish at the block's faces
      for (int j = 2; j <= 3; ++j) {
        for (int k = 2; k <= 3; ++k) {
          const int a = lattice_.Column(lattice_.basis().Index(i, j, k));
          inner = std::max(inner, gradient.row(a).norm());
        }
      }
    }
    // No force inside a body of uniform stress; 1e-8: the projection damps by as much.
    EXPECT_LT(inner, 1e-7 * gradient.rowwise().norm().maxCoeff());
  }
}

TEST_F(ElasticRelaxationTest, HessianAtRestIsTheSmallStrainStiffness) {
  for (const StrainCase& kind : kStrainCases) {
    FullStiffness small = StrainStiffness(lattice_, tissue_, {}, kind.dilatation);
    AddAlongEachAxis(supports_, &small);
    FullStiffness K;
    Strain(kind).Hessian(U_, false, &K);
    EXPECT_LT((K - small).norm(), 1e-12 * small.norm());
  }
}

TEST_F(ElasticRelaxationTest, FiniteMetricIsStVenantKirchhoffWithoutLambdaOnLinearMaps) {
  // eta sum (G - I)^2 = mu |E|^2 with mu = 4 eta, E = (G - I) / 2, over the same volume.
  Matrix3d F;
  F << 1.2, 0.3, -0.1, -0.2, 0.9, 0.15, 0.05, -0.25, 1.1;
  const double density = HyperelasticLaw(MaterialLaw::kStVenantKirchhoff, {2000, 0}).Energy(F);
  const double volume = tissue_.weights.sum();
  EXPECT_NEAR(Metric(false).Energy(LinearMap(F)) / (density * volume), 1, 1e-12);
}

TEST_F(ElasticRelaxationTest, AllSolversAgreeForSmallDisplacements) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(1e-6, 0, 2e-6));
  AddContact(kPress, Vector3d(0.15, 0.1, 0.1), Vector3d(0, 0, -1e-6));
  for (const auto& energy : All(true)) {
    FullStiffness K;
    energy->Hessian(Points::Zero(lattice_.size(), 3), false, &K);
    MakeCholeskyRelaxation(K)->Relax(&contacts_, &U_);
    const Points linear = U_;
    EXPECT_TRUE(MakeNewtonRelaxation(*energy)->Relax(&contacts_, &U_).converged);
    // The energies differ from the linear one by strain, about 1e-6 / 0.025 m.
    EXPECT_LT((U_ - linear).norm(), 1e-3 * linear.norm());
    EXPECT_TRUE(
        MakeGaussSeidelRelaxation(K, {.max_sweeps = 20000})->Relax(&contacts_, &U_).converged);
    // The tolerance, 1e-6, times what slow convergence hides behind it.
    EXPECT_LT((U_ - linear).norm(), 1e-3 * linear.norm());
  }
}

TEST_F(ElasticRelaxationTest, LargeLiftsConvergeWithExactContacts) {
  const auto energies = All(true);
  for (const auto& energy : energies) {
    // St. Venant-Kirchhoff and the metric soften under a point that presses 20 mm deep until they
    // are no longer convex, and then converge linearly.
    const double size = energy == energies[0] || energy == energies[1] ? 1 : 0.4;
    contacts_.Clear();
    AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), size * Vector3d(0.02, 0, 0.04));
    AddContact(kPress, Vector3d(0.15, 0.1, 0.1), size * Vector3d(0, 0, -0.02));
    AddContact(kPress, Vector3d(0.15, 0.05, 0.1), size * Vector3d(0, 0, 0.06));
    const auto newton = MakeNewtonRelaxation(*energy, {.max_iterations = 30});
    const RelaxationResult result = newton->Relax(&contacts_, &U_);
    EXPECT_TRUE(result.converged) << result.residual;
    EXPECT_LE(result.iterations, 24);  // 20 measured: a third of a second of hand motion at once
    EXPECT_LT((PositionOf(0) - contacts_[0].target_W).norm(), 1e-9);
    EXPECT_NEAR(PositionOf(1).z(), contacts_[1].target_W.z(), 1e-9);
    EXPECT_LT(contacts_[1].force_W.z(), 0);
    EXPECT_EQ(contacts_[2].force_W.norm(), 0);  // a press never pulls
  }
}

TEST_F(ElasticRelaxationTest, ABudgetInSecondsCountsOnlyWithAClock) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.03));
  Nanoseconds now = 0;
  const auto clock = [&now] { return now += 4'000'000; };  // 4 ms an iteration
  NewtonOptions options{.max_iterations = 30, .budget = 0.010};
  EXPECT_TRUE(MakeNewtonRelaxation(Strain(kNeoHookean), options)->Relax(&contacts_, &U_).converged);
  options.clock = clock;
  const RelaxationResult cut =
      MakeNewtonRelaxation(Strain(kNeoHookean), options)->Relax(&contacts_, &U_);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.iterations, 1);  // 8 ms by the next reading, and 4 more would pass 10
  EXPECT_GT(cut.residual, 0);
  options.budget = 1e-6;  // one iteration is always made
  EXPECT_EQ(MakeNewtonRelaxation(Strain(kNeoHookean), options)->Relax(&contacts_, &U_).iterations,
            1);
}

TEST_F(ElasticRelaxationTest, ABudgetOfThreeIterationsHoldsTheContactsAndCatchesUp) {
  AddContact(kGrasp, Vector3d(0.05, 0.05, 0.1), Vector3d(0.01, 0, 0.03));
  const auto newton = MakeNewtonRelaxation(Strain(kNeoHookean), {.max_iterations = 3});
  RelaxationResult result;
  for (int step = 0; step < 12; ++step) {
    result = newton->Relax(&contacts_, &U_);
    EXPECT_LE(result.iterations, 3);
    EXPECT_LT((PositionOf(0) - contacts_[0].target_W).norm(), 1e-9);
    if (step == 0) {
      EXPECT_FALSE(result.converged);
      EXPECT_GT(result.residual, 1e-3);
    }
  }
  EXPECT_TRUE(result.converged) << result.residual;
}

// The energy rises as the point yields to its local compliance, while the potential falls.
TEST_F(ElasticRelaxationTest, APressThatIndentsLocallyConvergesInEveryStep) {
  constexpr double kLocal = 5e-3;  // m/N; of the block under the point: about 2e-3
  for (const bool tip : {false, true}) {
    const auto newton = MakeNewtonRelaxation(Strain(kNeoHookean));
    for (int step = 1; step <= 20; ++step) {
      const double depth = 0.03 * std::sin(0.3 * step);  // it also lets go
      contacts_.Clear();
      AddContact(kPress, Vector3d(0.1, 0.07, 0.1), Vector3d(0, 0, -depth));
      ContactConstraints::Row& row = contacts_[0];
      if (tip) {
        row.indentation = LocalIndentation({}, Vector3d::UnitZ(), 0.0025, 0.02);
      } else {
        row.local_compliance_W = kLocal * Matrix3d::Identity();
      }
      const RelaxationResult result = newton->Relax(&contacts_, &U_);
      EXPECT_TRUE(result.converged) << "step " << step << ", residual " << result.residual;
      EXPECT_LE(result.iterations, 10) << "step " << step;
      const double at = PositionOf(0).z() + (row.LocalCompliance() * row.force_W).z();
      if (depth > 0) {
        EXPECT_NEAR(at, 0.1 - depth, 1e-7);
      }
    }
  }
}

TEST_F(ElasticRelaxationTest, ATipThatOnlyTouchesHasConverged) {
  AddContact(kPress, Vector3d(0.1, 0.07, 0.1), Vector3d(0, 0, -1e-17));  // round-off deep
  const RelaxationResult result = MakeNewtonRelaxation(Strain(kNeoHookean))->Relax(&contacts_, &U_);
  EXPECT_TRUE(result.converged) << result.residual;
  EXPECT_EQ(result.iterations, 1);
}

TEST_F(ElasticRelaxationTest, APressThatLetsGoHasNotConvergedBeforeTheOrganIsAtRest) {
  AddContact(kGrasp, Vector3d(0.1, 0.07, 0.1), Vector3d(0.02, 0, 0.06));
  const auto newton = MakeNewtonRelaxation(Strain(kNeoHookean), {.max_iterations = 3});
  for (int step = 0; step < 20; ++step) newton->Relax(&contacts_, &U_);
  contacts_.Clear();
  AddContact(kPress, Vector3d(0.1, 0.07, 0.1), Vector3d(0, 0, 0.2));  // far above: no force
  RelaxationResult result = newton->Relax(&contacts_, &U_);
  EXPECT_EQ(contacts_[0].force_W.norm(), 0);
  EXPECT_GT(U_.norm(), 1e-3) << "three iterations from so far are not enough";
  EXPECT_FALSE(result.converged);
  for (int step = 0; step < 20 && !result.converged; ++step) {
    result = newton->Relax(&contacts_, &U_);
  }
  EXPECT_TRUE(result.converged);
  EXPECT_LT(U_.norm(), 1e-6);
}

// One whole step without a search diverges from step to step, but never beyond all numbers.
TEST_F(ElasticRelaxationTest, ASingleIterationAStepStaysFinite) {
  const auto newton = MakeNewtonRelaxation(Strain(kNeoHookean), {.max_iterations = 1});
  for (const double x : {0.02, 0.05, 0.08}) {
    AddContact(kGrasp, Vector3d(x, 0.05, 0.1), Vector3d(0, 0, -0.06));
  }
  for (int step = 0; step < 40; ++step) {
    newton->Relax(&contacts_, &U_);
    ASSERT_TRUE(U_.allFinite()) << step;
  }
}

TEST_F(ElasticRelaxationTest, APointPushedThroughTheBodyRecovers) {
  const auto newton = MakeNewtonRelaxation(Strain(kNeoHookean), {.max_iterations = 40});
  // The point moves from the top through the held bottom in one step: cells invert.
  AddContact(kGrasp, Vector3d(0.1, 0.07, 0.1), Vector3d(0, 0, -0.12));
  newton->Relax(&contacts_, &U_);
  EXPECT_TRUE(U_.allFinite());
  EXPECT_TRUE(contacts_[0].force_W.allFinite());
  EXPECT_LT(contacts_[0].force_W.z(), 0);
  EXPECT_NEAR(PositionOf(0).z(), -0.02, 1e-9);
  // With the point back in its place, the body is at rest again.
  contacts_[0].target_W = contacts_[0].p_rest_W + Vector3d(0, 0, 1e-6);
  newton->Relax(&contacts_, &U_);
  EXPECT_LT(U_.norm(), 1e-4);
}

}  // namespace
}  // namespace hpdm
