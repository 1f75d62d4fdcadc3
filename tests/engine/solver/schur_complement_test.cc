#include "engine/solver/schur_complement.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdlib>

#include "tests/support/lattice_body.h"

namespace hpdm {
namespace {

constexpr int kSlots = 6;
// Relative: the regularisation of 1e-9 times the condition of Sigma.
constexpr double kRegularisation = 1e-5;

class SchurComplementTest : public testing::Test {
 protected:
  // Uses the functions nearest to a point, all but `unused` slots of them.
  void Choose(const Vector3d& p, int unused = 0) {
    const Vector3d points[] = {p};
    active_.ChooseNearest(functions_.centres(), points, kSlots - unused);
    schur_.SetActiveFunctions(active_);
  }
  // [K K_c; K_c^T K_loc] of the functions in use, with K_c = K Y and K_loc = Sigma + Y^T K Y.
  Eigen::MatrixXd JointStiffness() const {
    const Eigen::Index n = body_.K.rows();
    Eigen::MatrixXd Y = Eigen::MatrixXd::Zero(n, 3 * kSlots);
    Eigen::MatrixXd sigma = Eigen::MatrixXd::Identity(3 * kSlots, 3 * kSlots);
    for (int s = 0; s < kSlots; ++s) {
      const int a = active_.Function(s);
      if (a < 0) continue;
      Y.middleCols<3>(3 * s) = functions_.Coupling(a);
      for (int t = 0; t < kSlots; ++t) {
        const int b = active_.Function(t);
        if (b < 0) continue;
        sigma.block<3, 3>(3 * s, 3 * t) = functions_.ReducedStiffness(a, b);
        if (s == t) sigma.block<3, 3>(3 * s, 3 * s) /= active_.Weight(s);
      }
    }
    Eigen::MatrixXd joint(n + 3 * kSlots, n + 3 * kSlots);
    joint.topLeftCorner(n, n) = body_.K;
    joint.topRightCorner(n, 3 * kSlots) = body_.K * Y;
    joint.bottomLeftCorner(3 * kSlots, n) = (body_.K * Y).transpose();
    joint.bottomRightCorner(3 * kSlots, 3 * kSlots) = sigma + Y.transpose() * body_.K * Y;
    return joint;
  }
  // Solves by the Schur complement: V = Sigma^-1 (g - Y^T f),  U = K^-1 f - Y V.
  Eigen::VectorXd Solve(const Eigen::VectorXd& load) const {
    const Eigen::Index n = body_.K.rows();
    Eigen::VectorXd V = load.tail(3 * kSlots), U = functions_.inverse() * load.head(n);
    schur_.Reduce(load.head(n), V);
    schur_.Solve(V);
    schur_.AddCoupling(-1, V, U);
    Eigen::VectorXd solution(load.size());
    solution << U, V;
    return solution;
  }

  LatticeBody body_{0.3};
  RefinementBasis functions_ = body_.Local();
  ActiveRefinement active_{functions_.size(), kSlots};
  SchurComplement schur_{functions_, kSlots};
};

TEST_F(SchurComplementTest, SolvesTheJointSystemOfLatticeAndLocalFunctions) {
  std::srand(1);
  for (const double x : {-0.05, 0.0, 0.02, 0.021}) {
    Choose(Vector3d(x, 0.01, 0.04));
    ASSERT_EQ(active_.used(), kSlots);
    const Eigen::MatrixXd joint = JointStiffness();
    const Eigen::VectorXd load = Eigen::VectorXd::Random(joint.rows());
    const Eigen::VectorXd expected = joint.ldlt().solve(load);
    EXPECT_LT((Solve(load) - expected).norm(), kRegularisation * expected.norm()) << x;
  }
}

TEST_F(SchurComplementTest, AnEmptySlotDoesNotMoveTheLattice) {
  Choose(Vector3d(0, 0.01, 0.04));
  Choose(Vector3d(0, 0.01, 0.04), 2);
  ASSERT_EQ(active_.used(), kSlots - 2);
  Eigen::VectorXd U = Eigen::VectorXd::Zero(body_.K.rows());
  for (int s = 0; s < kSlots; ++s) {
    if (active_.Function(s) >= 0) continue;
    schur_.AddCoupling(1, Eigen::VectorXd::Unit(3 * kSlots, 3 * s), U);
  }
  EXPECT_EQ(U.norm(), 0);
}

}  // namespace
}  // namespace hpdm
