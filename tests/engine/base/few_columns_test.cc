// Products, factors and solutions for a few columns against Eigen's, and bit for bit between widths.

#include "engine/base/few_columns.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>

namespace hpdm {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::array kWidths{VectorWidth::k16Bytes, VectorWidth::k32Bytes, VectorWidth::k64Bytes};
constexpr std::array<Index, 8> kSizes{1, 3, 4, 7, 8, 13, 40, 133};

// Returns a symmetric matrix with eigenvalues of at least 1.
MatrixXd Definite(Index n) {
  const MatrixXd M = MatrixXd::Random(n, n);
  return MatrixXd::Identity(n, n) + M * M.transpose();
}

// Calls act(width) for each width that this processor has; all results must have the same bits.
template <class Act>
MatrixXd SameForAllWidths(Act&& act) {
  const MatrixXd narrow = act(kWidths[0]);
  for (const VectorWidth width : kWidths) {
    if (HasVectors(width)) {
      EXPECT_EQ(MatrixXd(act(width)), narrow) << narrow.rows();
    }
  }
  return narrow;
}

TEST(FewColumns, FactorIsEigensAndLeavesTheUpperTriangle) {
  for (const Index n : kSizes) {
    MatrixXd A = Definite(n);
    const MatrixXd L = Eigen::LLT<MatrixXd>(A).matrixL();
    A.triangularView<Eigen::StrictlyUpper>().setConstant(7);
    const MatrixXd factor = SameForAllWidths([&](VectorWidth width) {
      MatrixXd factored = A;
      EXPECT_TRUE(FactorLower(factored, 0, width));
      return factored;
    });
    EXPECT_LT((MatrixXd(factor.triangularView<Eigen::Lower>()) - L).norm(), 1e-13 * L.norm()) << n;
    EXPECT_EQ(MatrixXd(factor.triangularView<Eigen::StrictlyUpper>()),
              MatrixXd(A.triangularView<Eigen::StrictlyUpper>()));
  }
}

// The first columns stay, and those of the rows below come from a solution.
TEST(FewColumns, FactorGoesOnFromItsFirstColumnsToTheLastBit) {
  for (const Index n : kSizes) {
    const MatrixXd A = Definite(n);
    MatrixXd whole = A;
    ASSERT_TRUE(FactorLower(whole));
    for (const Index done : {Index{0}, n / 3, n - 1, n}) {
      const MatrixXd factor = SameForAllWidths([&](VectorWidth width) {
        MatrixXd factored = A;
        factored.leftCols(done) = whole.leftCols(done);
        EXPECT_TRUE(FactorLower(factored, done, width));
        return MatrixXd(factored.triangularView<Eigen::Lower>());
      });
      EXPECT_EQ(factor, MatrixXd(whole.triangularView<Eigen::Lower>())) << n << ' ' << done;
    }
  }
}

TEST(FewColumns, FactorRefusesAMatrixThatIsNotDefinite) {
  for (const Index n : kSizes) {
    MatrixXd A = Definite(n);
    A(n - 1, n - 1) = 0;
    EXPECT_FALSE(FactorLower(A)) << n;
  }
}

TEST(FewColumns, SolutionsAreEigens) {
  for (const Index n : kSizes) {
    MatrixXd whole = MatrixXd::Zero(n + 9, n + 5);  // L is a part, with another stride
    const MatrixXd L = Eigen::LLT<MatrixXd>(Definite(n)).matrixL();
    whole.block(2, 3, n, n) = L;
    const FewColumns X = FewColumns::Random(n, kFewColumns);
    const MatrixXd down = SameForAllWidths([&](VectorWidth width) {
      FewColumns solved = X;
      SolveLower(whole.block(2, 3, n, n), solved, width);
      return MatrixXd(solved);
    });
    EXPECT_LT((L * down - X).norm(), 1e-12 * X.norm()) << n;
    const MatrixXd up = SameForAllWidths([&](VectorWidth width) {
      FewColumns solved = X;
      SolveLowerTransposed(whole.block(2, 3, n, n), solved, width);
      return MatrixXd(solved);
    });
    EXPECT_LT((L.transpose() * up - X).norm(), 1e-12 * X.norm()) << n;
  }
}

TEST(FewColumns, ProductIsEigensAlsoWhenItIsAdded) {
  for (const Index m : kSizes) {
    for (const Index k : kSizes) {
      const RowMajorMatrix A = RowMajorMatrix::Random(m, k + 4);
      const FewColumns X = FewColumns::Random(k, kFewColumns);
      const MatrixXd Y = SameForAllWidths([&](VectorWidth width) {
        FewColumns product(m, kFewColumns);
        Multiply(A.middleCols(1, k), X, product, width);
        return MatrixXd(product);
      });
      EXPECT_LT((Y - A.middleCols(1, k) * X).norm(), 1e-13 * (1 + Y.norm())) << m << ", " << k;
      const MatrixXd twice = SameForAllWidths([&](VectorWidth width) {
        FewColumns sum = Y;
        MultiplyAndAdd(A.middleCols(1, k), X, sum, width);
        return MatrixXd(sum);
      });
      EXPECT_LT((twice - 2 * Y).norm(), 1e-13 * (1 + Y.norm())) << m << ", " << k;
    }
  }
}

}  // namespace
}  // namespace hpdm
