#include "engine/solver/sparse_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdlib>
#include <vector>

#include "engine/base/error.h"

namespace hpdm {
namespace {

// The Laplacian of a grid of side x side points plus `support` on its diagonal.
ScalarStiffness Grid(int side, double support) {
  std::vector<Eigen::Triplet<double>> entries;
  const auto join = [&](int a, int b) {
    entries.insert(entries.end(), {{a, a, 1}, {b, b, 1}, {a, b, -1}, {b, a, -1}});
  };
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int a = side * y + x;
      entries.emplace_back(a, a, support);
      if (x + 1 < side) join(a, a + 1);
      if (y + 1 < side) join(a, a + side);
    }
  }
  ScalarStiffness A(side * side, side * side);
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

TEST(SparseCholesky, SolvesAsADenseInverse) {
  const ScalarStiffness A = Grid(7, 0.1);
  const SparseCholesky factor(A, "");
  std::srand(1);
  Points x = Points::Random(A.rows(), 3);
  const Points expected = Eigen::MatrixXd(A).inverse() * x;
  factor.Solve(x);
  EXPECT_LT((x - expected).norm(), 1e-12 * expected.norm());  // the condition is below 100
}

TEST(SparseCholesky, TriangularSolvesSplitTheQuadraticForm) {
  // |L^-1 P b|^2 = b^T A^-1 b.
  const ScalarStiffness A = Grid(7, 0.1);
  const SparseCholesky factor(A, "");
  Points lower = Points::Zero(A.rows(), 3);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows()), sparse = b;
  for (const int i : {3, 17, 40}) {
    b[i] = 1 + i;
    lower(factor.Place(i), 0) = sparse[factor.Place(i)] = b[i];
  }
  factor.SolveLower(&lower);
  factor.SolveLowerSparse(sparse);
  EXPECT_LT((lower.col(0) - sparse).norm(), 1e-13 * sparse.norm());
  const double form = b.dot(Eigen::MatrixXd(A).inverse() * b);
  EXPECT_NEAR(sparse.squaredNorm(), form, 1e-12 * form);
}

TEST(SparseCholesky, AChainHasNoFillIn) {
  std::vector<Eigen::Triplet<double>> entries;
  constexpr int kLinks = 50;
  for (int a = 0; a < kLinks; ++a) {
    entries.emplace_back(a, a, 2.5);
    if (a > 0) entries.insert(entries.end(), {{a, a - 1, -1}, {a - 1, a, -1}});
  }
  ScalarStiffness A(kLinks, kLinks);
  A.setFromTriplets(entries.begin(), entries.end());
  EXPECT_EQ(SparseCholesky(A, "").nonzeros(), 2 * kLinks - 1);
}

// The last pivot is zero, or round-off of either sign.
TEST(SparseCholesky, ASingularMatrixIsRefusedWithTheRemedy) {
  for (const double stiffness : {1.0, 0.1, 0.3, 0.7, 1.1}) {
    for (int side = 2; side < 9; ++side) {
      try {
        SparseCholesky(stiffness * Grid(side, 0), "add a support");
        FAIL() << "a free grid of " << side << " x " << side;
      } catch (const InputError& error) {
        EXPECT_STREQ(error.what(), "add a support");
      }
    }
  }
}

}  // namespace
}  // namespace hpdm
