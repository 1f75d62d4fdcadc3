#include "engine/solver/symmetric_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cstdlib>
#include <limits>

namespace hpdm {
namespace {

// Eigenvalues from 1 to some 300.
Eigen::MatrixXd PositiveDefinite(int size) {
  std::srand(7);
  const Eigen::MatrixXd B = Eigen::MatrixXd::Random(size, size);
  return Eigen::MatrixXd::Identity(size, size) + B * B.transpose();
}

// Sizes around the number of pivots that are swept together, 48.
TEST(SymmetricInverse, TakesTheMatrixToTheIdentityWhateverItsSize) {
  for (const int size : {1, 2, 47, 48, 49, 96, 130}) {
    const Eigen::MatrixXd A = PositiveDefinite(size);
    Eigen::MatrixXd inverse = A;
    EXPECT_GT(InvertSymmetric(&inverse), 1e-4);
    // Round-off times the condition number.
    EXPECT_LT((A * inverse - Eigen::MatrixXd::Identity(size, size)).norm(), 1e-11) << size;
    EXPECT_TRUE(inverse == inverse.transpose());
  }
  Eigen::MatrixXd nothing(0, 0);
  InvertSymmetric(&nothing);
  EXPECT_EQ(nothing.size(), 0);
}

TEST(SymmetricInverse, ReadsTheLowerTriangleAlone) {
  Eigen::MatrixXd A = PositiveDefinite(60), lower = A;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(
      std::numeric_limits<double>::quiet_NaN());
  InvertSymmetric(&A);
  InvertSymmetric(&lower);
  EXPECT_TRUE(A == lower);
}

TEST(SymmetricInverse, ReturnsTheConditionOfADiagonalMatrixExactly) {
  Eigen::MatrixXd A = Eigen::Vector4d(1, 2, 4, 1024).asDiagonal();
  EXPECT_EQ(InvertSymmetric(&A), 1.0 / 1024);  // powers of two: no round-off
}

TEST(SymmetricInverse, RefusesMatricesThatAreNotPositiveDefinite) {
  Eigen::MatrixXd indefinite = PositiveDefinite(100);
  indefinite(70, 70) = -1;
  EXPECT_EQ(InvertSymmetric(&indefinite), 0);
  Eigen::MatrixXd unknown = PositiveDefinite(100);
  unknown(70, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(InvertSymmetric(&unknown), 0);
  // Rank 40 of 100: the other pivots are round-off.
  const Eigen::MatrixXd B = PositiveDefinite(100).leftCols(40);
  Eigen::MatrixXd singular = B * B.transpose();
  EXPECT_LT(InvertSymmetric(&singular), 1e-15);
}

}  // namespace
}  // namespace hpdm
