#include "engine/solver/packed_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <cstdlib>

namespace hpdm {
namespace {

/// A positive definite matrix whose unknowns have scales from 1 to 1e6.
Eigen::MatrixXd Unequal(Eigen::Index size) {
  std::srand(1);
  const Eigen::MatrixXd G = Eigen::MatrixXd::Random(size, size);
  const Eigen::VectorXd scale =
      Eigen::VectorXd::LinSpaced(size, 0, 6).unaryExpr([](double e) { return std::pow(10, e); });
  return scale.asDiagonal() *
         (G * G.transpose() / static_cast<double>(size) + Eigen::MatrixXd::Identity(size, size)) *
         scale.asDiagonal();
}

class PackedInverseTest : public testing::TestWithParam<int> {};

TEST_P(PackedInverseTest, MultipliesToSinglePrecisionOfEachUnknown) {
  const Eigen::MatrixXd A = Unequal(GetParam());
  const PackedInverse packed(A);
  PackedInverse::Workspace space(A.rows());
  const Eigen::VectorXd x = Eigen::VectorXd::Random(A.rows());
  Eigen::VectorXd y(A.rows());
  packed.Multiply(x, &space, y);
  // Each of the products A_ij x_j is rounded by at most 2^-24.
  const Eigen::VectorXd most = 0x1p-24 * (A.cwiseAbs() * x.cwiseAbs()) * (1 + 1e-6);
  EXPECT_TRUE(((y - A * x).cwiseAbs().array() <= most.array()).all());
  Eigen::VectorXd same = x;
  packed.Multiply(same, &space, same);
  EXPECT_EQ(same, y);
}

TEST_P(PackedInverseTest, IsSymmetricAndPositiveDefinite) {
  const Eigen::MatrixXd A = Unequal(GetParam());
  const PackedInverse packed(A);
  PackedInverse::Workspace space(A.rows());
  const Eigen::MatrixXd I = Eigen::MatrixXd::Identity(A.rows(), A.rows());
  Eigen::MatrixXd B(A.rows(), A.rows());
  for (Eigen::Index c = 0; c < A.cols(); ++c) packed.Multiply(I.col(c), &space, B.col(c));
  // The scales are multiplied in another order.
  EXPECT_TRUE(((B - B.transpose()).cwiseAbs().array() <= 1e-15 * B.cwiseAbs().array()).all());
  const Eigen::VectorXd unit = A.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = unit.asDiagonal() * B * unit.asDiagonal();
  EXPECT_GT(scaled.selfadjointView<Eigen::Lower>().eigenvalues().minCoeff(), 0);
}

TEST_P(PackedInverseTest, HasTheSameBitsAtEveryWidth) {
  const Eigen::MatrixXd A = Unequal(GetParam());
  PackedInverse::Workspace space(A.rows());
  const Eigen::VectorXd x = Eigen::VectorXd::Random(A.rows());
  Eigen::VectorXd narrow(A.rows()), y(A.rows());
  PackedInverse(A, VectorWidth::k16Bytes).Multiply(x, &space, narrow);
  for (const VectorWidth width : {VectorWidth::k32Bytes, VectorWidth::k64Bytes}) {
    if (!HasVectors(width)) continue;
    PackedInverse(A, width).Multiply(x, &space, y);
    EXPECT_EQ(y, narrow);
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes, PackedInverseTest, testing::Values(1, 8, 27, 120));

}  // namespace
}  // namespace hpdm
