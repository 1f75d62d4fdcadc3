#include "engine/contact/contact_solver.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace hpdm {
namespace {

using enum ContactConstraints::RowKind;
constexpr double kPad = 1e-6;  // relative: the pad of 1e-9 times the condition of the compliances

// Rows without a lattice: the tests give the compliance.
class ContactSolverTest : public testing::Test {
 protected:
  ContactConstraints::Row& Add(ContactConstraints::RowKind kind, const Vector3d& move) {
    ContactConstraints::Row& row = *contacts_.Add();
    row.kind = kind;
    row.p_rest_W = Vector3d(0.01 * contacts_.size(), 0, 0);
    row.target_W = row.p_rest_W + move;
    return row;
  }
  RelaxationResult Solve(const Eigen::MatrixXd& A) {
    solver_.Build(contacts_);
    solver_.compliance() = A;
    const RelaxationResult result = solver_.Solve();
    solver_.WriteForces(&contacts_);
    return result;
  }
  // A symmetric positive definite compliance, m/N.
  static Eigen::MatrixXd RandomCompliance(int size) {
    const Eigen::MatrixXd root = Eigen::MatrixXd::Random(size, size);
    return 1e-3 * (root * root.transpose() + Eigen::MatrixXd::Identity(size, size));
  }

  ContactConstraints contacts_{0};
  ContactSolver solver_;
};

TEST_F(ContactSolverTest, GraspForcesAreTheInverseComplianceTimesTheMoves) {
  std::srand(1);
  Eigen::VectorXd moves(6);
  moves << 0.01, -0.003, 0.002, 0.004, 0.001, -0.008;
  Add(kGrasp, moves.head(3));
  Add(kGrasp, moves.tail(3));
  const Eigen::MatrixXd A = RandomCompliance(6);
  const RelaxationResult result = Solve(A);
  EXPECT_TRUE(result.converged);
  EXPECT_FALSE(result.regularised);
  const Eigen::VectorXd forces = A.inverse() * moves;
  EXPECT_LT((contacts_[0].force_W - forces.head(3)).norm(), kPad * forces.norm());
  EXPECT_LT((contacts_[1].force_W - forces.tail(3)).norm(), kPad * forces.norm());
  EXPECT_EQ(contacts_[0].slip, 0);
}

// Points in a row whose compliance falls off with their distance. All 2^8 active sets are tried.
TEST_F(ContactSolverTest, PressesSolveTheComplementarityProblemThatEnumerationSolves) {
  constexpr int kPresses = 8;
  Eigen::MatrixXd A(kPresses, kPresses);
  for (int i = 0; i < kPresses; ++i) {
    for (int j = 0; j < kPresses; ++j) A(i, j) = 3e-3 * std::exp(-0.4 * std::abs(i - j));
  }
  std::srand(2);
  int released = 0;
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::VectorXd depth = 0.01 * Eigen::VectorXd::Random(kPresses);
    contacts_.Clear();
    for (int i = 0; i < kPresses; ++i) Add(kPress, Vector3d(0, 0, -depth[i]));
    EXPECT_TRUE(Solve(A).converged);
    int solutions = 0;
    for (int set = 0; set < 1 << kPresses; ++set) {
      std::vector<int> active;
      for (int i = 0; i < kPresses; ++i) {
        if ((set >> i & 1) != 0) active.push_back(i);
      }
      Eigen::VectorXd f = Eigen::VectorXd::Zero(kPresses);
      if (!active.empty()) f(active) = Eigen::MatrixXd(A(active, active)).inverse() * depth(active);
      if (f.minCoeff() < 0 || (A * f - depth).minCoeff() < -1e-12) continue;
      ++solutions;
      EXPECT_LE((solver_.forces() - f).norm(), kPad * f.norm()) << trial;
      released += ((depth.array() > 0) && (f.array() == 0)).count();
    }
    EXPECT_EQ(solutions, 1) << trial;
  }
  EXPECT_GT(released, 10) << "presses that their neighbours release";
}

TEST_F(ContactSolverTest, FrictionTakesItsShareOfTheNormalForce) {
  constexpr double kDepth = 0.006;
  Matrix3d C;
  C << 3e-3, 0, 5e-4, 0, 3e-3, 0, 5e-4, 0, 2e-3;
  ContactConstraints::Row& row = Add(kPress, Vector3d(0, 0, -kDepth));
  row.friction_W = Vector3d(0.2, 0.1, 0);
  row.local_compliance_W = C;
  Solve(Eigen::MatrixXd::Zero(1, 1));
  EXPECT_NEAR((C * row.force_W).z(), -kDepth, kPad * kDepth) << "the point is on the plane";
  EXPECT_NEAR(row.force_W.x(), -0.2 * row.force_W.z(), kPad);
  EXPECT_NEAR(row.force_W.y(), -0.1 * row.force_W.z(), kPad);
}

TEST_F(ContactSolverTest, LocalComplianceSoftensItsOwnRowAlone) {
  Add(kPress, Vector3d(0, 0, -0.004)).local_compliance_W = 1e-3 * Matrix3d::Identity();
  Add(kPress, Vector3d(0, 0, -0.004));
  Eigen::Matrix2d A;
  A << 2e-3, 1e-3, 1e-3, 2e-3;
  Solve(A);
  // 3 f + g = 4 and f + 2 g = 4, in N.
  EXPECT_NEAR(contacts_[0].force_W.z(), -0.8, kPad);
  EXPECT_NEAR(contacts_[1].force_W.z(), -1.6, kPad);
}

// Two balls of different size on coupled half-spaces. Forces and depths follow from the radii of
// their contacts (Sneddon).
TEST_F(ContactSolverTest, BallsFollowTheirOwnLawsTogether) {
  const MaterialOptions tissue{.young = 5000, .poisson = 0.45};
  const double E_star = tissue.young / (1 - tissue.poisson * tissue.poisson);
  const double radii[] = {0.0025, 0.01}, resolved = 0.03;
  const double coupling = 0.4 * MeanKernelSinking() / (E_star * resolved);
  for (const auto& [b_0, b_1] : {std::pair(0.05, 0.7), {0.3, 0.02}, {0.6, 0.6}, {0.0, 0.4}}) {
    contacts_.Clear();
    double force[2], depth[2];
    for (int i = 0; i < 2; ++i) {
      const double b = i == 0 ? b_0 : b_1, R = radii[i];
      force[i] = E_star * R * R * ((b * b + 1) * std::atanh(b) - b);
      depth[i] = R * b * std::atanh(b);
    }
    if (b_0 == 0) depth[0] = -0.1 * coupling * force[1];  // between both surfaces: no contact
    for (int i = 0; i < 2; ++i) {
      Add(kPress, Vector3d(0, 0, -depth[i] - coupling * force[1 - i])).indentation =
          LocalIndentation(tissue, Vector3d::UnitZ(), radii[i], resolved);
    }
    const double own = MeanKernelSinking() / (E_star * resolved);
    const RelaxationResult result =
        Solve((Eigen::Matrix2d() << own, coupling, coupling, own).finished());
    EXPECT_TRUE(result.converged);
    for (int i = 0; i < 2; ++i) {
      EXPECT_NEAR(contacts_[i].f_n(), force[i], 1e-6 * force[1]) << b_0 << ' ' << i;
    }
  }
}

TEST_F(ContactSolverTest, CoincidentGraspsShareTheForceOfOne) {
  std::srand(3);
  const Matrix3d C = RandomCompliance(3);
  const Vector3d move(0.002, 0.001, -0.003);
  Add(kGrasp, move);
  Add(kGrasp, move);
  const RelaxationResult result = Solve(C.replicate(2, 2));
  EXPECT_TRUE(result.regularised);
  const Vector3d alone = C.inverse() * move;
  for (int i = 0; i < 2; ++i) {
    EXPECT_LT((contacts_[i].force_W - alone / 2).norm(), kPad * alone.norm());
    EXPECT_EQ(contacts_[i].slip, 0);
  }
}

TEST_F(ContactSolverTest, CoincidentGraspsThatArePulledApartSlip) {
  constexpr double kCompliance = 2e-3;  // m/N
  const Vector3d move(0.005, 0, 0);
  Add(kGrasp, move);
  Add(kGrasp, -move);
  Solve(kCompliance * Matrix3d::Identity().replicate(2, 2));
  const double alone = move.norm() / kCompliance;
  for (int i = 0; i < 2; ++i) {
    EXPECT_LE(contacts_[i].force_W.norm(), ContactSolver::kSlipping * alone * (1 + kPad));
    EXPECT_GE(contacts_[i].force_W.norm(), alone * (1 - kPad)) << "they still pull";
    // The tissue stays in the middle: the whole move is slip.
    EXPECT_NEAR(contacts_[i].slip * contacts_[i].force_W.norm(), move.norm(), kPad);
  }
}

}  // namespace
}  // namespace hpdm
