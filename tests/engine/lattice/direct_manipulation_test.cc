#include "engine/lattice/direct_manipulation.h"

#include <gtest/gtest.h>

#include <random>

namespace hpdm {
namespace {

ContactWeights RandomRows(int m, int n, std::mt19937* random) {
  ContactWeights rows(m, n);
  for (double& w : rows.reshaped()) w = (*random)() / 4294967296.0;
  for (int i = 0; i < m; ++i) rows.row(i) /= rows.row(i).sum();
  return rows;
}

TEST(DirectManipulation, MovesEveryContactExactlyThere) {
  std::mt19937 random(3);
  const ContactWeights rows = RandomRows(5, 40, &random);
  const Points change = Points::Random(5, 3) * 0.01;
  Points U = Points::Random(40, 3) * 0.01;
  const Points before = rows * U;
  EXPECT_EQ(MoveDirectly(rows, change, U), 5);
  // Round-off times the condition of B B^T (about 1e3 for random rows).
  EXPECT_LT((rows * U - before - change).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(DirectManipulation, OneContactIsEquationNine) {
  std::mt19937 random(4);
  const ContactWeights row = RandomRows(1, 20, &random);
  const Points change = (Points(1, 3) << 0.01, -0.02, 0.005).finished();
  Points U = Points::Zero(20, 3);
  MoveDirectly(row, change, U);
  const Points expected = row.transpose() * change / row.squaredNorm();
  EXPECT_LT((U - expected).cwiseAbs().maxCoeff(), 1e-16);
}

TEST(DirectManipulation, ChangeIsOfMinimumNorm) {
  std::mt19937 random(5);
  const ContactWeights rows = RandomRows(4, 30, &random);
  Points U = Points::Zero(30, 3);
  MoveDirectly(rows, Points::Random(4, 3), U);
  // Orthogonal to every change that moves no contact: projecting onto the row space keeps it.
  const Eigen::MatrixXd B = rows;
  const Eigen::MatrixXd projected = B.transpose() * (B * B.transpose()).ldlt().solve(B * U);
  EXPECT_LT((projected - U).cwiseAbs().maxCoeff(), 1e-12);
}

TEST(DirectManipulation, CoincidentContactsAreSafeAndShareTheirMean) {
  std::mt19937 random(6);
  ContactWeights rows = RandomRows(3, 20, &random);
  for (const double apart : {0.0, 1e-12, 1e-8}) {
    rows.row(1) = rows.row(0);
    rows(1, 0) += apart;
    Points change(3, 3);
    change << 0.01, 0, 0, 0.03, 0, 0, 0, 0.01, 0;
    Points U = Points::Zero(20, 3);
    EXPECT_EQ(MoveDirectly(rows, change, U), 2);
    EXPECT_TRUE(U.allFinite());
    const Points moved = rows * U;
    EXPECT_NEAR(moved(0, 0), 0.02, 1e-8);  // the mean; rows differ by at most 1e-8
    EXPECT_NEAR(moved(2, 1), 0.01, 1e-8);
    EXPECT_LT(U.norm(), 1);
  }
}

TEST(DirectManipulation, MoreContactsThanControlPointsAreSafe) {
  std::mt19937 random(7);
  const ContactWeights rows = RandomRows(kMaxToolRows, 8, &random);
  Points U = Points::Zero(8, 3);
  EXPECT_EQ(MoveDirectly(rows, Points::Constant(kMaxToolRows, 3, 0.01), U), 8);
  // A common translation is reachable: rows sum to one. Least squares finds it.
  EXPECT_LT((U - Points::Constant(8, 3, 0.01)).cwiseAbs().maxCoeff(), 1e-10);
}

}  // namespace
}  // namespace hpdm
