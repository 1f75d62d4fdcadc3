#include "engine/statics/static_newton.h"

#include <gtest/gtest.h>

#include "engine/statics/static_loads.h"
#include "tests/support/shapes.h"

namespace hpdm {
namespace {

struct Kind {
  EnergyType type;
  MaterialLaw law;
};
constexpr Kind kNeoHookean{EnergyType::kStrain, MaterialLaw::kNeoHookean};
constexpr Kind kStVenantKirchhoff{EnergyType::kStrain, MaterialLaw::kStVenantKirchhoff};
constexpr Kind kMetric{EnergyType::kMetric, MaterialLaw::kNeoHookean};

// An ellipsoid of 0.1 x 0.07 x 0.05 m half-axes (times `scale`) held in its lower part.
OrganModel Organ(const Kind& kind, StrainMeasure strain = StrainMeasure::kFinite,
                 double scale = 1) {
  OrganOptions options;
  options.name = "ellipsoid";
  options.energy.type = kind.type;
  options.energy.law = kind.law;
  options.energy.strain = strain;
  options.energy.alpha = 500;
  options.energy.beta *= scale * scale;
  options.lattice.local.functions = 0;
  options.lattice.margin *= scale;
  SupportOptions bottom;
  bottom.region = BoxFraction{Vector3d::Zero(), Vector3d(1, 1, 0.27)};
  options.supports.push_back(bottom);
  return OrganModel(options, Ellipsoid(scale * Vector3d(0.1, 0.07, 0.05), 3));
}

const Vector3d kAtTop(0.01, 0.005, 0.0494), kAtSide(0.0985, 0.008, 0.007);

LoadOptions ForceAt(const Vector3d& p, const Vector3d& force, double scale = 1) {
  LoadOptions load;
  load.organ = "ellipsoid";
  load.p_centre_W = scale * p;
  load.radius = scale * 0.015;
  load.force_W = scale * scale * force;
  return load;
}

LoadOptions Move(const Vector3d& p, const Vector3d& move) {
  LoadOptions load = ForceAt(p, Vector3d::Zero());
  load.force_W.reset();
  load.displacement_W = move;
  return load;
}

class StaticNewtonTest : public testing::TestWithParam<Kind> {
 protected:
  OrganModel organ_ = Organ(GetParam());
};
INSTANTIATE_TEST_SUITE_P(Energies, StaticNewtonTest,
                         testing::Values(kNeoHookean, kStVenantKirchhoff, kMetric));

TEST_P(StaticNewtonTest, LargeForcesAreBalanced) {
  const StaticSolution solution =
      StaticLoads(organ_, {ForceAt(kAtTop, {0.6, 0, 3}), ForceAt(kAtSide, {1.5, 0, 0.6})}).Solve();
  EXPECT_EQ(solution.share, 1);
  EXPECT_LE(solution.residual, 1e-9);  // the tolerance
  EXPECT_GT(solution.vertex_displacements.rowwise().norm().maxCoeff(), 0.006);
}

TEST_P(StaticNewtonTest, PrescribedDisplacementTakesTheForceThatMakesIt) {
  const Vector3d force(0.2, 0, 0.8);
  const StaticSolution by_force = StaticLoads(organ_, {ForceAt(kAtTop, force)}).Solve();
  const StaticSolution by_displacement =
      StaticLoads(organ_, {Move(kAtTop, by_force.load_displacements[0])}).Solve();
  // Residuals of 1e-9 times the condition of the load's own compliance.
  EXPECT_LT((by_displacement.load_forces[0] - force).norm(), 1e-6 * force.norm());
  EXPECT_LT((by_displacement.vertex_displacements - by_force.vertex_displacements).norm(),
            1e-6 * by_force.vertex_displacements.norm());
}

TEST_P(StaticNewtonTest, HeldPointsAreWhereTheyShouldBe) {
  const Vector3d move(0, 0.01, 0.03);
  const StaticSolution solution =
      StaticLoads(organ_, {Move(kAtTop, move), ForceAt(kAtSide, {0.2, 0, 0})}).Solve();
  EXPECT_EQ(solution.share, 1);
  EXPECT_LE(solution.residual, 1e-9);
  EXPECT_LT((solution.load_displacements[0] - move).norm(), 1e-12);
  EXPECT_EQ(solution.load_forces[1], Vector3d(0.2, 0, 0));
}

TEST_P(StaticNewtonTest, SmallLoadsAgreeWithTheStiffnessAtRest) {
  const StaticSolution finite = StaticLoads(organ_, {ForceAt(kAtTop, {2e-5, 0, -1e-4})}).Solve();
  const auto energy = organ_.finite_energy()->Clone();
  Points gradient = finite.control_displacements;
  FullStiffness K;
  energy->Hessian(Points::Zero(gradient.rows(), 3), false, &K);
  energy->Gradient(finite.control_displacements, &gradient);
  Eigen::MatrixXd U = Eigen::Map<Eigen::VectorXd>(gradient.data(), gradient.size());
  MakeComplianceSolver(K)->SolveLoads(U);
  const Eigen::Map<const Points> linear(U.data(), gradient.rows(), 3);
  // They differ by the strain, about 1e-6 m / 0.015 m.
  EXPECT_LT((finite.control_displacements - linear).norm(), 1e-3 * linear.norm());
}

TEST_P(StaticNewtonTest, SmallLoadsAgreeWithSmallStrain) {
  if (GetParam().type == EnergyType::kMetric) return;  // its two forms are different energies
  const std::vector<LoadOptions> loads = {ForceAt(kAtTop, {2e-5, 0, -1e-4})};
  const OrganModel linear = Organ(GetParam(), StrainMeasure::kSmall);
  const Points small = StaticLoads(linear, loads).Solve().vertex_displacements;
  const Points finite = StaticLoads(organ_, loads).Solve().vertex_displacements;
  // Finite strain has fewer points and leaves functions with little tissue out: 2.4 % stiffer.
  EXPECT_LT((finite - small).norm(), 3e-2 * small.norm());
}

// A force along z on the point `p` of the organ.
StaticLoadRows PointForce(const OrganModel& organ, const Vector3d& p, double force) {
  StaticLoadRows rows{Eigen::MatrixXd::Zero(3 * organ.lattice_organ()->lattice().size(), 1),
                      Eigen::VectorXd::Constant(1, force),
                      Eigen::VectorXd::Zero(1),
                      {false},
                      Eigen::MatrixXd::Zero(1, 1)};
  const WeightMatrix at = organ.lattice_organ()->lattice().Weights(p.transpose());
  for (WeightMatrix::InnerIterator it(at, 0); it; ++it) {
    rows.rows(3 * it.index() + 2, 0) = it.value();
  }
  return rows;
}

TEST_P(StaticNewtonTest, BodyRescaledByAThousandHasTheSameShape) {
  const double scale = 1000;
  const OrganModel large = Organ(GetParam(), StrainMeasure::kFinite, scale);
  const double force = 0.8;  // grows with the square of the length at equal stress
  const auto small_energy = organ_.finite_energy()->Clone();
  const auto large_energy = large.finite_energy()->Clone();
  const Points small = SolveStaticLoads(PointForce(organ_, kAtTop, force), small_energy.get()).U;
  const Points big =
      SolveStaticLoads(PointForce(large, scale * kAtTop, scale * scale * force), large_energy.get())
          .U /
      scale;
  const Points difference = organ_.weights() * (big - small);
  EXPECT_LT(difference.norm(), 1e-6 * (organ_.weights() * small).norm());
}

TEST(StaticNewton, EquilibriumDoesNotDependOnTheLoadSteps) {
  const OrganModel organ = Organ(kNeoHookean);
  const auto energy = organ.finite_energy()->Clone();
  const StaticLoadRows rows = PointForce(organ, kAtTop, 1);
  const StaticNewtonSolution one = SolveStaticLoads(rows, energy.get(), {.load_steps = 1});
  const StaticNewtonSolution many = SolveStaticLoads(rows, energy.get(), {.load_steps = 10});
  EXPECT_LE(one.residual, 1e-9);
  EXPECT_LT((one.U - many.U).norm(), 1e-7 * many.U.norm());  // 1e-9 times the stiffness's spread
}

TEST(StaticNewton, DeepPressesOfStVenantKirchhoffAreBoundedAndReported) {
  const LoadOptions press = Move(kAtTop, {0, 0, -0.03});
  const StaticSolution solution = StaticLoads(Organ(kStVenantKirchhoff), {press}).Solve();
  EXPECT_LE(solution.iterations, StaticNewtonOptions().max_total);
  // Either all of the press is in balance, or the share that was reached is reported.
  EXPECT_LE(solution.residual, solution.share < 1 ? 1e-3 : 1e-9);
  EXPECT_LT(solution.vertex_displacements.rowwise().norm().maxCoeff(), 0.1);
  EXPECT_EQ(StaticLoads(Organ(kNeoHookean), {press}).Solve().share, 1);
}

}  // namespace
}  // namespace hpdm
