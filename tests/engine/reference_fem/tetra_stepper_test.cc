#include "engine/reference_fem/tetra_stepper.h"

#include <gtest/gtest.h>

#include "tests/support/mesh_shapes.h"

namespace hpdm {
namespace {

/// A bar of 0.3 x 0.1 x 0.1 m held at x = 0, whose other end is a patch.
class SteppedBar : public testing::TestWithParam<int> {
 protected:
  SteppedBar() {
    const int n = GetParam();
    mesh_ = BoxTetraMesh(Vector3d::Zero(), Vector3d(0.3, 0.1, 0.1), {3 * n, n, n});
    material_.young = 5000;
    material_.poisson = 0.4;
  }
  /// The bar with springs at x = 0 and the other end displaced as given.
  TetraProblem Problem(const TetraBody& body, const Vector3d& displacement) const {
    TetraProblem problem = EmptyProblem(body);
    TetraRow end;
    for (int node = 0; node < mesh_.corners; ++node) {
      const double x = body.mesh().nodes(node, 0);
      if (x < 1e-9) problem.springs.At(node, node) += 1e5 * Matrix3d::Identity();
      if (x > 0.3 - 1e-9) end.emplace_back(node, 1.0);
    }
    for (auto& [node, weight] : end) weight /= static_cast<double>(end.size());
    problem.loads = {{end, std::nullopt, displacement}};
    return problem;
  }
  static Points Row(const Vector3d& displacement) { return displacement.transpose(); }

  TetraMesh mesh_;
  MaterialOptions material_;
};

// SolveTetra finds the same equilibrium with multipliers and a tangent of its own.
TEST_P(SteppedBar, EndsWhereNewtonsMethodWithMultipliersDoes) {
  const Vector3d bent(-0.05, 0, 0.12);
  for (const TetraMesh& mesh : {mesh_, Quadratic(mesh_)}) {
    const TetraBody body(mesh, material_, TetraLaw::kNeoHookean);
    const TetraProblem problem = Problem(body, bent);
    const TetraSolution expected = SolveTetra(body, problem, {.load_steps = 4});
    ASSERT_TRUE(expected.converged);
    for (const StepMethod method :
         {StepMethod::kQuasiNewton, StepMethod::kNewton, StepMethod::kConjugateGradients}) {
      TetraStepper stepper(Stepped(body), problem.springs, method);
      for (int step = 1; step <= 4; ++step) {
        EXPECT_TRUE(stepper.MoveTo({problem.loads[0].patch}, Row(0.25 * step * bent)).converged);
      }
      // Twice the tolerance of the residual, times the softest mode's share.
      EXPECT_LT((stepper.u() - expected.u).norm(), 5e-3 * expected.u.norm());
      EXPECT_LT((stepper.forces().row(0).transpose() - expected.forces[0]).norm(),
                1e-2 * expected.forces[0].norm());
    }
  }
}

TEST_P(SteppedBar, SmallStrainIsSolvedInOneRound) {
  const Vector3d moved(0.001, 0.002, -0.003);
  const TetraBody body(mesh_, material_, TetraLaw::kSmallStrain);
  const TetraProblem problem = Problem(body, moved);
  const TetraSolution expected = SolveTetra(body, problem);
  TetraStepper stepper(Stepped(body), problem.springs, StepMethod::kQuasiNewton);
  EXPECT_EQ(stepper.MoveTo({problem.loads[0].patch}, Row(moved)).rounds, 1);
  EXPECT_LT((stepper.u() - expected.u).norm(), 1e-8 * expected.u.norm());
  EXPECT_LT((stepper.forces().row(0).transpose() - expected.forces[0]).norm(),
            1e-8 * expected.forces[0].norm());
}

// Dead forces at the patch reach the same state through SolveCorotational.
TEST_P(SteppedBar, CorotationalStepsAreInEquilibrium) {
  const Vector3d bent(-0.02, 0, 0.06);
  const CorotationalBody body(mesh_, material_);
  const TetraProblem problem = Problem(TetraBody(mesh_, material_, TetraLaw::kSmallStrain), bent);
  std::vector<int> held;
  for (int node = 0; node < mesh_.corners; ++node) {
    if (mesh_.nodes(node, 0) < 1e-9) held.push_back(node);
  }
  for (const StepMethod method : {StepMethod::kNewton, StepMethod::kConjugateGradients}) {
    TetraStepper stepper(Stepped(body), problem.springs, method);
    const TetraStepper::Result result = stepper.MoveTo({problem.loads[0].patch}, Row(bent));
    EXPECT_TRUE(result.converged);
    Points forces = Points::Zero(mesh_.corners, 3);
    for (const auto& [node, weight] : problem.loads[0].patch) {
      forces.row(node) += weight * stepper.forces().row(0);
    }
    const Points expected = SolveCorotational(body, held, forces);
    EXPECT_LT((stepper.u() - expected).norm(), 1e-2 * expected.norm());
  }
}

// One tangent a step, from where the last one ended.
TEST_P(SteppedBar, OneRoundAStepFollowsTheEquilibriumFromBehind) {
  const Vector3d bent(-0.02, 0, 0.06);
  const CorotationalBody body(mesh_, material_);
  const TetraProblem problem = Problem(TetraBody(mesh_, material_, TetraLaw::kSmallStrain), bent);
  const auto walk = [&](int steps, int most_rounds) {
    TetraStepper stepper(Stepped(body), problem.springs, StepMethod::kConjugateGradients,
                         most_rounds);
    for (int step = 1; step <= steps; ++step) {
      const auto result =
          stepper.MoveTo({problem.loads[0].patch}, Row(static_cast<double>(step) / steps * bent));
      EXPECT_LE(result.rounds, most_rounds);
    }
    return stepper.u();
  };
  const Points end = walk(4, 200);
  const double four = (walk(4, 1) - end).norm() / end.norm();
  const double forty = (walk(40, 1) - end).norm() / end.norm();
  EXPECT_LT(forty, 0.02);
  EXPECT_LT(forty, 0.5 * four);
}

INSTANTIATE_TEST_SUITE_P(Meshes, SteppedBar, testing::Values(1, 2));

}  // namespace
}  // namespace hpdm
